//! The training of a critic as the one loop sees it.

use std::path::{Path, PathBuf};

use lifelike_checkpoint::Checkpoint;
use lifelike_report::ReportBuilder;
use lifelike_report::run::RunFolder;
use lifelike_train::{Budget, Scalar, Schedule, StepEnd, TrainingTask, Validation};

use super::file::EXTENSION;
use super::trainer::{CriticMetrics, CriticTrainer};
use crate::GenerationError;

impl CriticTrainer {
    /// Returns the file of the critic in a run's folder.
    pub fn critic_path(folder: &Path) -> PathBuf {
        folder.join(format!("motion{EXTENSION}"))
    }
}

impl TrainingTask for CriticTrainer {
    type Metrics = CriticMetrics;
    type Error = GenerationError;

    fn iteration(&self) -> u64 {
        self.epoch()
    }

    fn budget(&self) -> Budget {
        Budget::iterations(self.epoch(), self.plan().epochs)
    }

    fn schedule(&self) -> Schedule {
        let every = self.plan().validate_every;
        Schedule { checkpoint_every: every, validate_every: every, keep: 1 }
    }

    fn identity(&self) -> Vec<(&'static str, String)> {
        vec![("records of the controller", self.data.digest())]
    }

    fn step(&mut self) -> Result<CriticMetrics, GenerationError> {
        Ok(self.epoch_once())
    }

    fn scalars(&self, metrics: &CriticMetrics) -> Vec<Scalar> {
        metrics.step.scalars_with(&[("Train/mean_target", metrics.target)])
    }

    fn validate(&mut self) -> Result<Option<Validation>, GenerationError> {
        let Some([explained, predicted, returned]) = self.validate_once() else { return Ok(None) };
        let scalars = [
            ("Validation/explained_variance", explained),
            ("Validation/mean_value", predicted),
            ("Validation/mean_return", returned),
        ];
        let scalars = scalars.map(|(name, value)| (name.to_string(), value)).to_vec();
        Ok(Some(Validation { scalars, score: Some(explained) }))
    }

    fn checkpoint(&self) -> Result<Checkpoint, GenerationError> {
        self.save()
    }

    fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), GenerationError> {
        self.load(checkpoint)
    }

    fn finish(&mut self, folder: &RunFolder) -> Result<(), GenerationError> {
        self.critic().save(&Self::critic_path(folder.path()))
    }

    fn report(&self, report: ReportBuilder) -> ReportBuilder {
        let records = &self.data.records;
        let failures = records.end.iter().filter(|end| **end == StepEnd::Failed).count();
        report
            .fact("robot", self.data.robot.clone())
            .fact("controller (SHA-256)", self.data.controller.clone())
            .fact("control steps", records.len().to_string())
            .fact("failures", failures.to_string())
    }
}
