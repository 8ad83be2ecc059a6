//! The training of an augmentation as the one loop sees it.

use std::path::{Path, PathBuf};

use lifelike_checkpoint::Checkpoint;
use lifelike_report::ReportBuilder;
use lifelike_report::run::RunFolder;
use lifelike_train::supervised::StepMetrics;
use lifelike_train::{Budget, Scalar, Schedule, TrainingTask, Validation};

use super::trainer::AugmentationTrainer;
use crate::AugmentationError;
use crate::augmentation::EXTENSION;

impl AugmentationTrainer {
    /// Returns the file of the augmentation in a run's folder.
    pub fn path(&self, folder: &Path) -> PathBuf {
        folder.join(format!("{}{EXTENSION}", self.inputs().class))
    }
}

impl TrainingTask for AugmentationTrainer {
    type Metrics = StepMetrics;
    type Error = AugmentationError;

    fn iteration(&self) -> u64 {
        self.iteration()
    }

    fn budget(&self) -> Budget {
        Budget { done: self.iteration(), total: self.plan().iterations, minutes: self.plan().minutes }
    }

    fn schedule(&self) -> Schedule {
        let every = self.plan().validate_every;
        Schedule { checkpoint_every: every, validate_every: every, keep: 1 }
    }

    fn identity(&self) -> Vec<(&'static str, String)> {
        vec![("traces", self.digest().to_string())]
    }

    fn step(&mut self) -> Result<StepMetrics, AugmentationError> {
        Ok(self.iterate())
    }

    fn scalars(&self, metrics: &StepMetrics) -> Vec<Scalar> {
        metrics.scalars()
    }

    fn validate(&mut self) -> Result<Option<Validation>, AugmentationError> {
        let Some(errors) = self.validate_once() else { return Ok(None) };
        let named = self.inputs().selection.iter().zip(&errors);
        let scalars = named.map(|(row, error)| (format!("Validation/{}", row.measured), *error)).collect();
        let score = -errors.iter().sum::<f64>() / errors.len() as f64;
        Ok(Some(Validation { scalars, score: Some(score) }))
    }

    fn checkpoint(&self) -> Result<Checkpoint, AugmentationError> {
        self.save()
    }

    fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), AugmentationError> {
        self.load(checkpoint)
    }

    fn finish(&mut self, folder: &RunFolder) -> Result<(), AugmentationError> {
        self.augmentation().save(&self.path(folder.path()))
    }

    fn report(&self, report: ReportBuilder) -> ReportBuilder {
        let [learned, validated] = self.blocks();
        report
            .fact("class", self.inputs().class.clone())
            .fact("blocks learned from", learned.to_string())
            .fact("blocks validated on", validated.to_string())
            .fact("parameters", self.parameters().to_string())
    }
}
