//! Settings of an evaluator and of its training, as a TOML file has them.

use std::path::PathBuf;

use lifelike_train::limits::{PlanError, range, whole};

/// A training run of an evaluator, as its TOML file has it.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EvaluatorTrainingPlan {
    /// A built-in robot's name, or its MJCF or URDF file.
    pub robot: String,
    /// Folder of captioned clips of this robot.
    pub dataset: PathBuf,
    /// Networks and training.
    #[serde(default)]
    pub evaluator: EvaluatorPlan,
}

/// Settings of networks and training.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EvaluatorPlan {
    /// Key of all randomness.
    pub seed: u64,
    /// Numbers of an embedding.
    pub width: usize,
    /// Width of the convolutions.
    pub channels: usize,
    /// Residual blocks of the motion encoder.
    pub motion_blocks: usize,
    /// Residual blocks of the text encoder.
    pub text_blocks: usize,
    /// Most word pieces of the vocabulary.
    pub pieces: usize,
    /// Most rows of a motion; longer ones are cut (at random while training). 200 are 10 s.
    pub max_rows: usize,
    /// Pairs per iteration, each told from all others.
    pub batch: usize,
    /// Training iterations.
    pub iterations: u64,
    /// Learning rate after the warm-up; from there it falls by a cosine.
    pub learning_rate: f64,
    /// Iterations of the warm-up.
    pub warmup: u64,
    /// Standard deviation of the noise on standardized rows while training.
    pub noise: f64,
    /// Share of word pieces that are hidden while training.
    pub word_dropout: f64,
    /// Gradients are scaled down to this norm.
    pub max_gradient_norm: f64,
    /// Iterations between validations, by which the best networks are kept.
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
        let at = |key: &str| format!("evaluator.{key}");
        for (key, value, low, high) in [
            ("width", self.width, 2, 4096),
            ("channels", self.channels, 4, 2048),
            ("motion_blocks", self.motion_blocks, 0, 32),
            ("text_blocks", self.text_blocks, 0, 32),
            ("pieces", self.pieces, 74, 30_000),
            ("max_rows", self.max_rows, 4, 4000),
            ("batch", self.batch, 2, 4096),
        ] {
            whole(&at(key), value as u64, low, high)?;
        }
        whole(&at("iterations"), self.iterations, 1, u64::MAX)?;
        whole(&at("warmup"), self.warmup, 0, self.iterations)?;
        whole(&at("validate_every"), self.validate_every, 1, u64::MAX)?;
        range(&at("learning_rate"), self.learning_rate, 1e-9, 1.0)?;
        range(&at("noise"), self.noise, 0.0, 10.0)?;
        range(&at("word_dropout"), self.word_dropout, 0.0, 0.9)?;
        range(&at("max_gradient_norm"), self.max_gradient_norm, 1e-6, 1e9)
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
