//! Errors of training.

use crate::limits::PlanError;

/// Iterations in a row with a skipped gradient after which a training has diverged.
pub const DIVERGED: u64 = 100;

/// Errors of training.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrainError {
    /// A file or an input that cannot be used.
    #[error(transparent)]
    Input(#[from] lifelike_checkpoint::InputError),
    /// The training learns nothing any more.
    #[error(
        "iteration {iteration}: expected gradients that are finite, got none for {DIVERGED} iterations; try a smaller learning rate"
    )]
    Diverged {
        /// Iterations done.
        iteration: u64,
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
