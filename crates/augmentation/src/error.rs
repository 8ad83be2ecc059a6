//! Errors of simulation augmentation.

use std::path::{Path, PathBuf};

/// Errors of simulation augmentation.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AugmentationError {
    /// A file or an input that cannot be used.
    #[error(transparent)]
    Input(#[from] lifelike_checkpoint::InputError),
    /// A place of a log that is not what it should be.
    #[error("{path}: {place}: expected {expected}, got {got}")]
    Log {
        /// The file.
        path: PathBuf,
        /// Line, entry or column.
        place: String,
        /// The expected value.
        expected: String,
        /// The value found.
        got: String,
    },
    /// A plan asks for something impossible.
    #[error(transparent)]
    Plan(#[from] lifelike_train::PlanError),
    /// A trace is the problem.
    #[error(transparent)]
    Sim(#[from] lifelike_sim::SimError),
    /// A model file or checkpoint is the problem.
    #[error(transparent)]
    Checkpoint(#[from] lifelike_checkpoint::CheckpointError),
    /// A file of a run or a report is the problem.
    #[error(transparent)]
    Report(#[from] lifelike_report::ReportError),
    /// The training itself is the problem.
    #[error(transparent)]
    Train(#[from] lifelike_train::TrainError),
}

impl AugmentationError {
    /// Returns the error of a place in a log.
    pub(crate) fn log(path: &Path, place: impl ToString, expected: impl ToString, got: impl ToString) -> Self {
        Self::Log {
            path: path.to_owned(),
            place: place.to_string(),
            expected: expected.to_string(),
            got: got.to_string(),
        }
    }
}
