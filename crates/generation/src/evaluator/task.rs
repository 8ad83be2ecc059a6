//! The training of an evaluator as the one loop sees it.

use lifelike_checkpoint::Checkpoint;
use lifelike_report::run::RunFolder;
use lifelike_train::supervised::StepMetrics;
use lifelike_train::{Budget, Scalar, Schedule, TrainingTask, Validation};

use super::train::EvaluatorTrainer;
use crate::GenerationError;

/// Name of the file that a run leaves.
const FILE: &str = "motion.evaluator.safetensors";

impl TrainingTask for EvaluatorTrainer {
    type Metrics = StepMetrics;
    type Error = GenerationError;

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
        vec![("training motions", self.data())]
    }

    fn step(&mut self) -> Result<StepMetrics, GenerationError> {
        Self::step(self)
    }

    fn scalars(&self, now: &StepMetrics) -> Vec<Scalar> {
        now.scalars()
    }

    fn validate(&mut self) -> Result<Option<Validation>, GenerationError> {
        let Some(found) = self.choose()? else { return Ok(None) };
        let [one, two, three] = found.r_precision.map(|interval| interval.mean);
        let scalars = [
            ("Validation/r_precision_1", one),
            ("Validation/r_precision_2", two),
            ("Validation/r_precision_3", three),
            ("Validation/mm_dist", found.mm_dist.mean),
        ];
        let scalars = scalars.map(|(name, value)| (name.to_string(), value)).to_vec();
        Ok(Some(Validation { scalars, score: Some(Self::score(&found)) }))
    }

    fn checkpoint(&self) -> Result<Checkpoint, GenerationError> {
        self.save()
    }

    fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), GenerationError> {
        self.load(checkpoint)
    }

    fn finish(&mut self, folder: &RunFolder) -> Result<(), GenerationError> {
        self.evaluator().save(&folder.path().join(FILE))
    }
}
