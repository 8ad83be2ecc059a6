//! Errors of tracking policies and their environments.

use std::path::{Path, PathBuf};

use lifelike_train::PlanError;

/// Errors of tracking policies and their environments.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrackerError {
    /// A file cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// A file is not in the expected form.
    #[error("{path}: expected {expected}, got {got}")]
    Format {
        /// The file (with the line, where there are lines).
        path: String,
        /// The expected content.
        expected: String,
        /// The content found.
        got: String,
    },
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
    /// The character is the problem.
    #[error(transparent)]
    Character(#[from] lifelike_character::CharacterError),
    /// A clip is the problem.
    #[error(transparent)]
    Motion(#[from] lifelike_motion::MotionError),
    /// The robot is the problem.
    #[error(transparent)]
    Robot(#[from] lifelike_robot::RobotError),
    /// The simulation is the problem.
    #[error(transparent)]
    Simulation(#[from] lifelike_sim::SimError),
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

impl TrackerError {
    /// Returns a closure for `map_err` on file operations.
    pub fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Io { path, source }
    }
}
