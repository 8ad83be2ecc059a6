//! The training of a generator as the one loop sees it.

use lifelike_checkpoint::Checkpoint;
use lifelike_report::ReportBuilder;
use lifelike_report::run::RunFolder;
use lifelike_train::{Budget, Scalar, Schedule, TrainingTask, Validation};

use super::{GeneratorMetrics, GeneratorTrainer};
use crate::GenerationError;
use crate::generator::FILE;

impl TrainingTask for GeneratorTrainer {
    type Metrics = GeneratorMetrics;
    type Error = GenerationError;

    fn iteration(&self) -> u64 {
        Self::iteration(self)
    }

    fn budget(&self) -> Budget {
        Budget { minutes: self.plan().minutes, ..Budget::iterations(Self::iteration(self), self.plan().iterations) }
    }

    fn schedule(&self) -> Schedule {
        let every = self.plan().validate_every;
        Schedule { checkpoint_every: every, validate_every: every, keep: 1 }
    }

    fn identity(&self) -> Vec<(&'static str, String)> {
        vec![("captioned motion", self.data().describe())]
    }

    fn step(&mut self) -> Result<GeneratorMetrics, GenerationError> {
        Self::step(self)
    }

    fn scalars(&self, now: &GeneratorMetrics) -> Vec<Scalar> {
        now.step.scalars_with(now.realism.map(|realism| ("Train/realism", realism)).as_slice())
    }

    fn validate(&mut self) -> Result<Option<Validation>, GenerationError> {
        let loss = self.validation_loss()?;
        Ok(Some(Validation { scalars: vec![("Validation/loss".to_string(), loss)], score: Some(-loss) }))
    }

    fn checkpoint(&self) -> Result<Checkpoint, GenerationError> {
        Self::checkpoint(self)
    }

    fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), GenerationError> {
        Self::restore(self, checkpoint)
    }

    fn finish(&mut self, folder: &RunFolder) -> Result<(), GenerationError> {
        self.generator().save(&folder.path().join(FILE))
    }

    fn report(&self, report: ReportBuilder) -> ReportBuilder {
        report.fact("parameters", self.parameters().to_string()).fact("data", self.data().describe())
    }
}
