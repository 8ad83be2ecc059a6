//! The training of a sequence autoencoder as the one loop sees it.

use lifelike_checkpoint::Checkpoint;
use lifelike_train::supervised::StepMetrics;
use lifelike_train::{Budget, Scalar, Schedule, TrainingTask, Validation};

use super::sequences::{HeldOut, Sequences};
use super::train::SequenceTrainer;
use crate::RepresentationError;

impl<S: Sequences> TrainingTask for SequenceTrainer<S> {
    type Metrics = StepMetrics;
    type Error = RepresentationError;

    fn iteration(&self) -> u64 {
        Self::iteration(self)
    }

    fn budget(&self) -> Budget {
        Budget::iterations(Self::iteration(self), self.plan().iterations)
    }

    fn schedule(&self) -> Schedule {
        let every = self.plan().validate_every;
        Schedule { checkpoint_every: every, validate_every: every, keep: 1 }
    }

    fn identity(&self) -> Vec<(&'static str, String)> {
        vec![("training sequences", self.data().describe())]
    }

    fn step(&mut self) -> Result<StepMetrics, RepresentationError> {
        Self::step(self)
    }

    fn scalars(&self, now: &StepMetrics) -> Vec<Scalar> {
        now.scalars()
    }

    fn validate(&mut self) -> Result<Option<Validation>, RepresentationError> {
        let errors = self.errors(HeldOut::Validation)?;
        // A set without sequences has no error, and none of its networks is the best.
        let score = Some(-errors.mse).filter(|_| !errors.each.is_empty());
        let scalars = [("Validation/mse", errors.mse), ("Validation/spread", errors.spread)];
        Ok(Some(Validation { scalars: scalars.map(|(name, value)| (name.to_string(), value)).to_vec(), score }))
    }

    fn checkpoint(&self) -> Result<Checkpoint, RepresentationError> {
        Self::checkpoint(self)
    }

    fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), RepresentationError> {
        Self::restore(self, checkpoint)
    }
}
