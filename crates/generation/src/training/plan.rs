//! Settings of a generator and of its training, a TOML file.

use std::path::PathBuf;

use lifelike_nn::schedules::cosine;
use lifelike_nn::transformer::encoder::EncoderSizes;
use lifelike_train::limits::wrong;
use lifelike_train::plan;

use crate::GenerationError;
use crate::space::SpaceKind;

/// A training of a generator. The defaults train within an hour on two cores on 8 h of motion.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GeneratorPlan {
    /// Robot: a built-in name, or an MJCF or URDF file.
    pub robot: String,
    /// Captioned motion: folders with a `dataset.jsonl`; other clips are captioned by their container or name.
    pub clips: Vec<PathBuf>,
    /// Seed of everything random.
    #[schemars(extend("unit" = "1"))]
    pub seed: u64,
    /// Kind of the tokens.
    pub space: SpaceKind,
    /// Length at which motion is cropped (s).
    #[schemars(extend("unit" = "s"), range(min = 0.5, max = 60.0))]
    pub max_seconds: f64,
    /// Number D of diffusion steps.
    #[schemars(extend("unit" = "1"), range(min = 2, max = 10_000))]
    pub diffusion_steps: usize,
    /// Size c of a token.
    #[schemars(extend("unit" = "1"), range(min = 2, max = 4096))]
    pub width: usize,
    /// Number of layers.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 64))]
    pub layers: usize,
    /// Number of attention heads of a layer; a divisor of the width.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 256))]
    pub heads: usize,
    /// Inner width of the feed-forward part.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 1u64 << 16))]
    pub inner: usize,
    /// Largest number of word pieces that are learned on the captions.
    #[schemars(extend("unit" = "1"), range(min = 100, max = 1u64 << 20))]
    pub pieces: usize,
    /// The network sees the duration of the motion.
    pub duration: bool,
    /// Weight of joint velocities in the loss of the space `spline`; rows contain them already.
    ///
    /// Squared errors of differences of neighbouring control points, each in that difference's own variance. A limb
    /// that swings fast and little (a hand that waves) counts as much as its place.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1e6))]
    pub velocity_weight: f64,
    /// Share of motions that are shown without their caption, for classifier-free guidance.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1.0))]
    pub condition_dropout: f64,
    /// Motions per iteration.
    #[schemars(extend("unit" = "motions"), range(min = 1, max = 1u64 << 16))]
    pub batch: usize,
    /// Motions that pass through the network at once on one core.
    ///
    /// In parts of another size gradients are the same up to rounding, which is why this belongs to the plan.
    #[schemars(extend("unit" = "motions"), range(min = 1, max = 1u64 << 16))]
    pub part: usize,
    /// Training iterations.
    #[schemars(extend("unit" = "iterations"), range(min = 1, max = 1u64 << 40))]
    pub iterations: u64,
    /// Wall time after which the training ends; none: only the iterations count (min).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "min"), range(min = 0.01, max = 1e6))]
    pub minutes: Option<f64>,
    /// Largest learning rate.
    #[schemars(extend("unit" = "1"), range(min = 1e-9, max = 10.0))]
    pub learning_rate: f64,
    /// Iterations over which the learning rate rises linearly from 0.
    #[schemars(extend("unit" = "iterations"), range(min = 0, max = 1u64 << 40))]
    pub warmup: u64,
    /// Share of the learning rate that is left at the end of a cosine; 1 keeps it constant.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1.0))]
    pub final_learning_rate: f64,
    /// Norm to which gradients are scaled down.
    #[schemars(extend("unit" = "1"), range(min = 1e-9, max = 1e9))]
    pub max_gradient_norm: f64,
    /// Decay of the weights' moving average.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1.0))]
    pub ema: f64,
    /// Iterations between two validations and checkpoints.
    #[schemars(extend("unit" = "iterations"), range(min = 1, max = 1u64 << 40))]
    pub validate_every: u64,
}

impl Default for GeneratorPlan {
    fn default() -> Self {
        Self {
            robot: "lima".into(),
            clips: Vec::new(),
            seed: 0,
            space: SpaceKind::default(),
            max_seconds: 10.0,
            diffusion_steps: 50,
            width: 128,
            layers: 4,
            heads: 4,
            inner: 512,
            pieces: 1024,
            duration: true,
            velocity_weight: 1.0,
            condition_dropout: 0.1,
            batch: 64,
            part: 8,
            iterations: 10_000,
            minutes: None,
            learning_rate: 5e-4,
            warmup: 500,
            final_learning_rate: 0.05,
            max_gradient_norm: 1.0,
            ema: 0.9999,
            validate_every: 500,
        }
    }
}

impl GeneratorPlan {
    /// Checks every range.
    ///
    /// # Errors
    /// The first key out of range.
    pub fn check(&self) -> Result<(), GenerationError> {
        plan::check("", self)?;
        if !self.width.is_multiple_of(self.heads) || !self.width.is_multiple_of(2) {
            let expected = format!("a divisor of the width {}, which is even", self.width);
            return Err(wrong("heads", &expected, self.heads).into());
        }
        Ok(())
    }

    /// Returns the transformer's sizes.
    pub fn encoder(&self) -> EncoderSizes {
        EncoderSizes { width: self.width, layers: self.layers, heads: self.heads, inner: self.inner }
    }

    /// Returns the learning rate at an iteration (counted from 0).
    pub fn learning_rate_at(&self, iteration: u64) -> f64 {
        let risen = if iteration < self.warmup { (iteration + 1) as f64 / self.warmup as f64 } else { 1.0 };
        self.learning_rate * risen * cosine(iteration, self.iterations, self.final_learning_rate)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn plans_survive_toml_and_say_what_is_wrong() {
        for space in [SpaceKind::Frames, SpaceKind::default()] {
            let plan = GeneratorPlan { space, minutes: Some(3.0), ..GeneratorPlan::default() };
            assert_eq!(toml::from_str::<GeneratorPlan>(&toml::to_string(&plan).unwrap()).unwrap(), plan);
        }
        let plan = |text: &str| toml::from_str::<GeneratorPlan>(text);
        assert!(plan("").unwrap().check().is_ok());
        assert!(plan("witdh = 3").unwrap_err().to_string().contains("unknown field `witdh`"));
        assert!(plan("space = { kind = 'bezier' }").unwrap_err().to_string().contains("bezier"));
        let error = |text: &str| plan(text).unwrap().check().unwrap_err().to_string();
        assert_eq!(error("batch = 0"), "plan: batch: expected 1 to 65536, got 0");
        assert_eq!(error("heads = 3"), "plan: heads: expected a divisor of the width 128, which is even, got 3");
        assert!(error("space = { kind = 'spline', knot_seconds = 0.0 }").contains("space.knot_seconds"));
        assert!(error("ema = nan").contains("plan: ema"));
    }
}
