//! Settings of an evaluator and of its training, as a TOML file has them.

use std::path::PathBuf;

use lifelike_train::limits::{PlanError, whole};
use lifelike_train::plan;

/// A training run of an evaluator, as its TOML file has it.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EvaluatorTrainingPlan {
    /// Robot: a built-in name, or an MJCF or URDF file.
    pub robot: String,
    /// Folder of captioned clips of this robot.
    pub dataset: PathBuf,
    /// Networks and training.
    #[serde(default)]
    pub evaluator: EvaluatorPlan,
}

/// Settings of networks and training.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EvaluatorPlan {
    /// Seed of everything random.
    #[schemars(extend("unit" = "1"))]
    pub seed: u64,
    /// Size of an embedding.
    #[schemars(extend("unit" = "1"), range(min = 2, max = 4096))]
    pub width: usize,
    /// Width of the convolutions.
    #[schemars(extend("unit" = "1"), range(min = 4, max = 2048))]
    pub channels: usize,
    /// Residual blocks of the motion encoder.
    #[schemars(extend("unit" = "1"), range(min = 0, max = 32))]
    pub motion_blocks: usize,
    /// Residual blocks of the text encoder.
    #[schemars(extend("unit" = "1"), range(min = 0, max = 32))]
    pub text_blocks: usize,
    /// Largest number of word pieces of the vocabulary.
    #[schemars(extend("unit" = "1"), range(min = 74, max = 30_000))]
    pub pieces: usize,
    /// Largest length of a motion; 200 rows are 10 s. Longer ones are cropped, at random while training.
    #[schemars(extend("unit" = "rows"), range(min = 4, max = 4000))]
    pub max_rows: usize,
    /// Pairs per iteration, each of which is contrasted with all others.
    #[schemars(extend("unit" = "pairs"), range(min = 2, max = 4096))]
    pub batch: usize,
    /// Training iterations.
    #[schemars(extend("unit" = "iterations"), range(min = 1))]
    pub iterations: u64,
    /// Learning rate after the warm-up; from there it falls by a cosine.
    #[schemars(extend("unit" = "1"), range(min = 1e-9, max = 1.0))]
    pub learning_rate: f64,
    /// Iterations of the warm-up.
    #[schemars(extend("unit" = "iterations"))]
    pub warmup: u64,
    /// Standard deviation of the noise on standardized rows while training.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 10.0))]
    pub noise: f64,
    /// Share of word pieces that are hidden while training.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 0.9))]
    pub word_dropout: f64,
    /// Norm to which gradients are scaled down.
    #[schemars(extend("unit" = "1"), range(min = 1e-6, max = 1e9))]
    pub max_gradient_norm: f64,
    /// Iterations between validations, by which the best networks are kept.
    #[schemars(extend("unit" = "iterations"), range(min = 1))]
    pub validate_every: u64,
}

impl Default for EvaluatorPlan {
    fn default() -> Self {
        Self {
            seed: 1,
            width: 128,
            channels: 96,
            motion_blocks: 3,
            text_blocks: 3,
            pieces: 800,
            max_rows: 200,
            batch: 64,
            iterations: 2000,
            learning_rate: 1e-3,
            warmup: 100,
            noise: 0.1,
            word_dropout: 0.1,
            max_gradient_norm: 10.0,
            validate_every: 200,
        }
    }
}

impl EvaluatorPlan {
    /// Checks every value.
    ///
    /// # Errors
    /// The first value out of range.
    pub fn check(&self) -> Result<(), PlanError> {
        plan::check("evaluator", self)?;
        whole("evaluator.warmup", self.warmup, 0, self.iterations)
    }

    /// Returns the learning rate at an iteration (counted from 0).
    pub fn learning_rate_at(&self, iteration: u64) -> f64 {
        if iteration < self.warmup {
            return self.learning_rate * (iteration + 1) as f64 / self.warmup as f64;
        }
        let (done, all) = (iteration - self.warmup, self.iterations - self.warmup);
        self.learning_rate * lifelike_nn::schedules::cosine(done, all, 0.01)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn plans_are_checked_and_unknown_keys_refused() {
        let read = |text: &str| toml::from_str::<EvaluatorTrainingPlan>(&format!("robot='a'\ndataset='b'\n{text}"));
        assert_eq!(read("").unwrap().evaluator, EvaluatorPlan::default());
        assert!(EvaluatorPlan::default().check().is_ok());
        assert!(read("[evaluator]\nwdth = 3").unwrap_err().to_string().contains("unknown field `wdth`"));
        for (text, told) in [
            ("batch = 1", "evaluator.batch: expected 2 to 4096, got 1"),
            ("warmup = 3000", "evaluator.warmup: expected 0 to 2000, got 3000"),
            ("noise = nan", "evaluator.noise"),
        ] {
            let error = read(&format!("[evaluator]\n{text}")).unwrap().evaluator.check().unwrap_err().to_string();
            assert!(error.contains(told), "{error}");
        }
    }

    #[test]
    fn the_rate_rises_and_falls() {
        let plan = EvaluatorPlan { warmup: 10, iterations: 110, learning_rate: 1.0, ..EvaluatorPlan::default() };
        assert_eq!((plan.learning_rate_at(0), plan.learning_rate_at(9), plan.learning_rate_at(10)), (0.1, 1.0, 1.0));
        assert!((plan.learning_rate_at(109) - 0.01).abs() < 1e-3);
    }
}
