//! Errors of the command line, and the exit codes that scripts see.

use lifelike_augmentation::AugmentationError;
use lifelike_character::CharacterError;
use lifelike_checkpoint::{CheckpointError, InputError};
use lifelike_evaluation::EvaluationError;
use lifelike_generation::GenerationError;
use lifelike_language::LanguageError;
use lifelike_motion::MotionError;
use lifelike_report::ReportError;
use lifelike_representation::RepresentationError;
use lifelike_robot::RobotError;
use lifelike_runtime::RuntimeError;
use lifelike_sim::SimError;
use lifelike_tracking::TrackerError;
use lifelike_train::{PlanError, TrainError};

/// A failed command.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// The work itself failed.
    #[error("{0}")]
    Failed(String),
    /// Arguments that contradict each other or name nothing.
    #[error("{0}")]
    Usage(String),
    /// A file that is not what it should be.
    #[error("{0}")]
    Input(String),
    /// This build has not what is asked for.
    #[error("{0}")]
    Unavailable(String),
    /// Ctrl-C; what was done so far is saved.
    #[error("interrupted: {0}")]
    Interrupted(String),
}

impl CliError {
    /// The exit code.
    pub fn code(&self) -> u8 {
        match self {
            Self::Failed(_) => 1,
            Self::Usage(_) => 2,
            Self::Input(_) => 3,
            Self::Unavailable(_) => 4,
            Self::Interrupted(_) => 130,
        }
    }

    /// A file that cannot be read or written: bad input where there is no such file or where it holds something else, a failure where
    /// the machine refuses (a full disk, missing permission).
    pub fn io(source: &std::io::Error, message: String) -> Self {
        use std::io::ErrorKind::{InvalidData, InvalidInput, IsADirectory, NotADirectory, NotFound, UnexpectedEof};
        let is_input = matches!(
            source.kind(),
            InvalidData | InvalidInput | IsADirectory | NotADirectory | NotFound | UnexpectedEof
        );
        if is_input { Self::Input(message) } else { Self::Failed(message) }
    }

    /// A file that cannot be written: bad input where a pipe or a link has its name, else a failure.
    pub fn write(path: &std::path::Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |error| {
            let message = format!("{}: {error}", path.display());
            match error.kind() {
                std::io::ErrorKind::InvalidInput => Self::Input(message),
                _ => Self::Failed(message),
            }
        }
    }
}

/// Codes of a crate's errors: bad input, unless an error inside knows better.
macro_rules! codes {
    ($($error:ident $(: $($inner:ident)+)?,)+) => {$(
        impl From<$error> for CliError {
            fn from(error: $error) -> Self {
                match error {
                    $error::Input(error) => error.into(),
                    $($($error::$inner(error) => error.into(),)+)?
                    _ => Self::Input(error.to_string()),
                }
            }
        }
    )+};
}

codes! {
    MotionError, LanguageError, RobotError, CheckpointError, ReportError,
    EvaluationError: Simulation,
    TrainError: Report,
    RepresentationError: Report Train,
    GenerationError: Report Train,
    AugmentationError: Report Train Sim,
    TrackerError: Simulation Report Train,
}

impl From<InputError> for CliError {
    fn from(error: InputError) -> Self {
        match &error {
            InputError::Io { source, .. } => Self::io(source, error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<CharacterError> for CliError {
    fn from(error: CharacterError) -> Self {
        match &error {
            CharacterError::Io { source, .. } => Self::io(source, error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<PlanError> for CliError {
    fn from(error: PlanError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<RuntimeError> for CliError {
    fn from(error: RuntimeError) -> Self {
        match error {
            RuntimeError::Input(error) => error.into(),
            RuntimeError::Robot(error) => error.into(),
            RuntimeError::Motion(error) => error.into(),
            RuntimeError::Checkpoint(error) => error.into(),
            RuntimeError::Bus { .. } => Self::Failed(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<SimError> for CliError {
    fn from(error: SimError) -> Self {
        match error {
            SimError::EngineUnavailable { .. } => Self::Unavailable(error.to_string()),
            SimError::UnknownEngine { .. } => Self::Usage(error.to_string()),
            _ => Self::Failed(error.to_string()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_say_whose_fault_it_is() {
        use std::io::{Error, ErrorKind};
        let code = |kind: ErrorKind| {
            let source = Error::from(kind);
            CliError::from(InputError::Io { path: "a.bvh".into(), source }).code()
        };
        assert_eq!([ErrorKind::NotFound, ErrorKind::InvalidData, ErrorKind::IsADirectory].map(code), [3; 3]);
        assert_eq!(code(ErrorKind::InvalidInput), 3, "a pipe or a link at the place of an output");
        assert_eq!(
            [ErrorKind::StorageFull, ErrorKind::PermissionDenied, ErrorKind::ReadOnlyFilesystem].map(code),
            [1; 3]
        );
    }
}
