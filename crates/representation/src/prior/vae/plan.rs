//! Settings of a convolutional motion prior and of its training, a table of a TOML file.

use lifelike_nn::adam::Rule;
use lifelike_nn::schedules::{Cyclical, WarmRestarts};

use super::file::Flat;
use crate::RepresentationError;
use crate::prior::kind::KindPlan;
use crate::prior::window_plan::WindowPlan;
use lifelike_train::plan;

/// Settings of a β-VAE. Defaults are the thesis' (4.3.1 and Table 4.1) where it states them.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(from = "Flat", into = "Flat")]
#[schemars(!from, !into, default, deny_unknown_fields)]
pub struct VaePlan {
    /// Windows to train on. In files their keys stand beside the others, and `seed` is the seed of everything random.
    #[schemars(flatten)]
    pub windows: WindowPlan,
    /// Size d_z of the latent code.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 4096))]
    pub latent: usize,
    /// Width of the convolutions; 104 gives about 0.8 M parameters.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 4096))]
    pub channels: usize,
    /// Residual blocks in the encoder, and in the decoder.
    #[schemars(extend("unit" = "1"), range(min = 0, max = 64))]
    pub blocks: usize,
    /// Principal components beside encoder and decoder, which then learn what these leave (not in the thesis).
    ///
    /// They are fitted before the first iteration and stay as they are.
    pub linear_path: bool,
    /// Windows per iteration.
    #[schemars(extend("unit" = "windows"), range(min = 1, max = 1u64 << 16))]
    pub batch: usize,
    /// Training iterations, which the thesis calls epochs.
    #[schemars(extend("unit" = "iterations"), range(min = 1, max = 1u64 << 40))]
    pub iterations: u64,
    /// Optimizer: the thesis' RAdam, Adam, or Muon.
    ///
    /// Muon gets further in the same number of steps at rates up to 0.003 and fails at 0.01. RAdam holds its step
    /// back for about the first 2000 steps: its rectification is 0.2 at step 100 and 0.4 at step 333 for β₂ = 0.999.
    /// This costs nothing in 50 000 iterations and most of a short budget.
    pub optimizer: Rule,
    /// Learning rate at the beginning of each cosine period.
    #[schemars(extend("unit" = "1"), range(min = 1e-9, max = 1.0))]
    pub learning_rate: f64,
    /// Iterations until the first warm restart, T_0.
    #[schemars(extend("unit" = "iterations"), range(min = 1, max = 1u64 << 40))]
    pub restart_first: u64,
    /// Length of a cosine period by that of the one before, T_mult.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 1000))]
    pub restart_factor: u64,
    /// Weight β of the KL divergence.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1000.0))]
    pub kl_weight: f64,
    /// Cycles of the KL schedule (Fu et al. 2019).
    #[schemars(extend("unit" = "1"), range(min = 1, max = 1_000_000))]
    pub kl_cycles: u64,
    /// Rising share of each KL cycle.
    #[schemars(extend("unit" = "1"), range(min = 1e-6, max = 1.0))]
    pub kl_ratio: f64,
    /// Norm to which gradients are scaled down; the default only catches outliers (the thesis does not clip).
    #[schemars(extend("unit" = "1"), range(min = 1e-6, max = 1e9))]
    pub max_gradient_norm: f64,
}

impl Default for VaePlan {
    fn default() -> Self {
        Self {
            windows: WindowPlan::default(),
            latent: 64,
            channels: 104,
            blocks: 4,
            linear_path: false,
            batch: 512,
            iterations: 50_000,
            optimizer: Rule::Radam,
            learning_rate: 0.003,
            restart_first: 1000,
            restart_factor: 5,
            kl_weight: 0.002,
            kl_cycles: 7,
            kl_ratio: 0.5,
            max_gradient_norm: 100.0,
        }
    }
}

impl VaePlan {
    /// Returns the learning rate at an iteration (counted from 0). A restart in the last tenth of the plan is left
    /// out: the rate would end high, and the few iterations left cannot learn again what a high rate undoes. Four
    /// iterations after a restart took the reconstruction of held-out joints from 8 to 13 degrees.
    pub fn learning_rate_at(&self, iteration: u64) -> f64 {
        let restarts = WarmRestarts { first: self.restart_first, factor: self.restart_factor, floor: 0.0 };
        let last = restarts.begin_of_period(self.iterations);
        let late = last > self.iterations - self.iterations / 10;
        if late && iteration >= last { 0.0 } else { self.learning_rate * restarts.at(iteration) }
    }

    /// Returns the weight of the KL divergence at an iteration (counted from 0).
    pub fn kl_weight_at(&self, iteration: u64) -> f64 {
        let cycles = Cyclical { total: self.iterations, cycles: self.kl_cycles, ratio: self.kl_ratio };
        self.kl_weight * cycles.at(iteration)
    }
}

impl KindPlan for VaePlan {
    fn windows(&self) -> &WindowPlan {
        &self.windows
    }

    fn latent_size(&self) -> usize {
        self.latent
    }

    fn describe_code(&self) -> String {
        "the mean of a beta-VAE's code".to_owned()
    }

    fn check(&self) -> Result<(), RepresentationError> {
        Ok(plan::check("", self)?)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// A plan of minutes: 4000 iterations of Adam in two cosine periods, 800 and 3200.
    fn short() -> VaePlan {
        VaePlan { optimizer: Rule::Adam, restart_first: 800, restart_factor: 4, iterations: 4000, ..VaePlan::default() }
    }

    fn read(text: &str) -> Result<VaePlan, String> {
        let plan: VaePlan = toml::from_str(text).map_err(|error| error.to_string())?;
        plan.check().map_err(|error| error.to_string())?;
        Ok(plan)
    }

    #[test]
    fn a_plan_survives_toml_and_unknown_or_absurd_keys_are_refused() {
        let plan = short();
        assert_eq!(read(&toml::to_string(&plan).unwrap()).unwrap(), plan);
        assert_eq!(read("").unwrap(), VaePlan::default());
        let absurd =
            ["chanels = 3", "batch = 0", "kl_ratio = 0.0", "learning_rate = nan", "floors = { height = -1.0 }"];
        for bad in absurd {
            assert!(read(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_restart_at_the_very_end_is_left_out_and_others_are_not() {
        let rate = |plan: &VaePlan, i| plan.learning_rate_at(i) / plan.learning_rate;
        let late = VaePlan { iterations: 4000, restart_first: 666, restart_factor: 5, ..VaePlan::default() };
        assert_eq!([rate(&late, 0), rate(&late, 666), rate(&late, 3996), rate(&late, 3999)], [1.0, 1.0, 0.0, 0.0]);
        let whole = short();
        assert!(rate(&whole, 799) < 1e-4 && rate(&whole, 800) == 1.0 && rate(&whole, 3999) < 1e-4);
        let thesis = VaePlan::default();
        assert_eq!([rate(&thesis, 1000), rate(&thesis, 6000), rate(&thesis, 31_000)], [1.0; 3]);
        assert!(rate(&thesis, 49_999) > 0.9, "the thesis' budget ends in the middle of a period");
    }
}
