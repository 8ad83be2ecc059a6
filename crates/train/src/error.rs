//! Errors of training.

use crate::limits::PlanError;

/// Errors of training.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrainError {
    /// Two things that must fit each other do not.
    #[error("{what}: expected {expected}, got {got}")]
    Mismatch {
        /// The things compared.
        what: String,
        /// The expected value.
        expected: String,
        /// The value found.
        got: String,
    },
    /// A plan asks for something impossible.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A checkpoint or policy file is the problem.
    #[error(transparent)]
    Checkpoint(#[from] lifelike_checkpoint::CheckpointError),
    /// A file of a run or a report is the problem.
    #[error(transparent)]
    Report(#[from] lifelike_report::ReportError),
}
