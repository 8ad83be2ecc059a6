//! Errors of the data of chapter 3.

use lifelike::CliError;
use lifelike_train::PlanError;

/// Errors of the data of chapter 3.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SequencesError {
    /// A file or an input that cannot be used.
    #[error(transparent)]
    Input(#[from] lifelike_checkpoint::InputError),
    /// A plan asks for something impossible.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A clip is the problem.
    #[error(transparent)]
    Motion(#[from] lifelike_motion::MotionError),
    /// The learned representation is the problem.
    #[error(transparent)]
    Representation(#[from] lifelike_representation::RepresentationError),
}

impl From<SequencesError> for CliError {
    fn from(error: SequencesError) -> Self {
        match error {
            SequencesError::Input(error) => error.into(),
            SequencesError::Representation(error) => error.into(),
            _ => Self::Input(error.to_string()),
        }
    }
}
