//! The training of a β-VAE as the one loop sees it.

use lifelike_checkpoint::Checkpoint;
use lifelike_train::{Budget, Scalar, Schedule, TrainingTask};

use super::train::{VaeMetrics, VaeTrainer};
use crate::RepresentationError;
use crate::prior::kind::PriorTraining;
use crate::prior::{MotionPrior, Windows};

/// Iterations between checkpoints.
const SAVE_EVERY: u64 = 200;

impl TrainingTask for VaeTrainer {
    type Metrics = VaeMetrics;
    type Error = RepresentationError;

    fn iteration(&self) -> u64 {
        Self::iteration(self)
    }

    fn budget(&self) -> Budget {
        Budget::iterations(Self::iteration(self), self.plan().iterations)
    }

    fn schedule(&self) -> Schedule {
        Schedule { checkpoint_every: SAVE_EVERY, validate_every: 0, keep: 1 }
    }

    fn identity(&self) -> Vec<(&'static str, String)> {
        vec![("training clips", self.data())]
    }

    fn step(&mut self) -> Result<VaeMetrics, RepresentationError> {
        Self::step(self)
    }

    fn scalars(&self, now: &VaeMetrics) -> Vec<Scalar> {
        [
            ("Loss/total", now.loss),
            ("Loss/reconstruction", now.reconstruction),
            ("Loss/kl", now.kl),
            ("Schedule/kl_weight", now.kl_weight),
            ("Schedule/learning_rate", now.learning_rate),
            ("Gradient/norm", now.gradient_norm),
            ("Gradient/skipped", now.skipped as f64),
        ]
        .map(|(name, value)| (name.to_string(), value))
        .to_vec()
    }

    fn checkpoint(&self) -> Result<Checkpoint, RepresentationError> {
        Self::checkpoint(self)
    }

    fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), RepresentationError> {
        Self::restore(self, checkpoint)
    }
}

impl PriorTraining for VaeTrainer {
    fn describe(now: &VaeMetrics) -> String {
        format!("reconstruction {:.3}  KL {:.1}", now.reconstruction, now.kl)
    }

    fn parameters(&self) -> usize {
        Self::parameters(self)
    }

    fn prior(&self) -> Result<MotionPrior, RepresentationError> {
        Ok(Self::prior(self))
    }

    fn watched(&self) -> &Windows {
        Self::watched(self)
    }
}
