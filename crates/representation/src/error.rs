//! Errors of learned representations of motion.

use lifelike_train::PlanError;

/// Errors of learned representations of motion.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RepresentationError {
    /// A file or an input that cannot be used.
    #[error(transparent)]
    Input(#[from] lifelike_checkpoint::InputError),
    /// A plan asks for something impossible.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The character is the problem.
    #[error(transparent)]
    Character(#[from] lifelike_character::CharacterError),
    /// A clip is the problem.
    #[error(transparent)]
    Motion(#[from] lifelike_motion::MotionError),
    /// Sizes that make no network.
    #[error(transparent)]
    Network(#[from] lifelike_nn::transformer::NetworkError),
    /// A pass through a network that cannot be made.
    #[error(transparent)]
    Pass(#[from] lifelike_nn::transformer::passes::PassError),
    /// A checkpoint or policy file is the problem.
    #[error(transparent)]
    Checkpoint(#[from] lifelike_checkpoint::CheckpointError),
    /// A file of a run or a report is the problem.
    #[error(transparent)]
    Report(#[from] lifelike_report::ReportError),
    /// The training itself is the problem.
    #[error(transparent)]
    Train(#[from] lifelike_train::TrainError),
}
