//! What the command line can fail with, and the exit codes that scripts see.

use lifelike_character::CharacterError;
use lifelike_checkpoint::CheckpointError;
use lifelike_evaluation::EvaluationError;
use lifelike_motion::MotionError;
use lifelike_report::ReportError;
use lifelike_representation::RepresentationError;
use lifelike_robot::RobotError;
use lifelike_sequences::SequencesError;
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

    /// A file that cannot be written.
    pub fn write(path: &std::path::Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |error| Self::Failed(format!("{}: {error}", path.display()))
    }
}

impl From<MotionError> for CliError {
    fn from(error: MotionError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<CharacterError> for CliError {
    fn from(error: CharacterError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<RobotError> for CliError {
    fn from(error: RobotError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<CheckpointError> for CliError {
    fn from(error: CheckpointError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<SimError> for CliError {
    fn from(error: SimError) -> Self {
        match error {
            SimError::Engine { .. } => Self::Unavailable(error.to_string()),
            _ => Self::Failed(error.to_string()),
        }
    }
}

impl From<ReportError> for CliError {
    fn from(error: ReportError) -> Self {
        match error {
            ReportError::Io { .. } => Self::Failed(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<PlanError> for CliError {
    fn from(error: PlanError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<TrainError> for CliError {
    fn from(error: TrainError) -> Self {
        match error {
            TrainError::Report(error) => error.into(),
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<RepresentationError> for CliError {
    fn from(error: RepresentationError) -> Self {
        match error {
            RepresentationError::Report(error) => error.into(),
            RepresentationError::Train(error) => error.into(),
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<SequencesError> for CliError {
    fn from(error: SequencesError) -> Self {
        match error {
            SequencesError::Io { .. } => Self::Failed(error.to_string()),
            SequencesError::Representation(error) => error.into(),
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<TrackerError> for CliError {
    fn from(error: TrackerError) -> Self {
        match error {
            TrackerError::Io { .. } => Self::Failed(error.to_string()),
            TrackerError::Simulation(error) => error.into(),
            TrackerError::Report(error) => error.into(),
            TrackerError::Train(error) => error.into(),
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<EvaluationError> for CliError {
    fn from(error: EvaluationError) -> Self {
        match error {
            EvaluationError::Simulation(error) => error.into(),
            EvaluationError::Tracker(error) => error.into(),
            _ => Self::Input(error.to_string()),
        }
    }
}
