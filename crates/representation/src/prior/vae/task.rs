//! The training of a β-VAE as the one loop sees it.

use lifelike_checkpoint::Checkpoint;
use lifelike_train::{Budget, Scalar, Schedule, TrainingTask, Validation};

use super::train::{VaeMetrics, VaeTrainer};
use crate::RepresentationError;
use crate::prior::kind::PriorTraining;
use crate::prior::{MotionPrior, Windows};

/// Iterations between checkpoints.
const SAVE_EVERY: u64 = 200;

/// Iterations between measurements of the reconstruction of held-out clips.
const VALIDATE_EVERY: u64 = 1000;

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
        let validate_every = if self.has_held_out() { VALIDATE_EVERY } else { 0 };
        Schedule { checkpoint_every: SAVE_EVERY, validate_every, keep: 1 }
    }

    fn identity(&self) -> Vec<(&'static str, String)> {
        vec![("training clips", self.data())]
    }

    fn step(&mut self) -> Result<VaeMetrics, RepresentationError> {
        Self::step(self)
    }

    fn scalars(&self, now: &VaeMetrics) -> Vec<Scalar> {
        let own =
            [("Loss/reconstruction", now.reconstruction), ("Loss/kl", now.kl), ("Schedule/kl_weight", now.kl_weight)];
        now.step.scalars_with(&own)
    }

    /// Measures the reconstruction of held-out clips. No score: the last weights are kept, whatever it says.
    fn validate(&mut self) -> Result<Option<Validation>, RepresentationError> {
        let report = self.report()?;
        let whole = [
            ("Validation/joints_deg", report.window.joints_deg),
            ("Validation/effectors_mm", report.window.effectors_mm),
            ("Validation/height_mm", report.window.height_mm),
            ("Validation/orientation_deg", report.window.orientation_deg),
            ("Validation/centre_joints_deg", report.centre.joints_deg),
        ];
        let scalars = whole.map(|(name, value)| (name.to_string(), value)).to_vec();
        Ok(Some(Validation { scalars, score: None }))
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
