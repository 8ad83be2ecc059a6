//! Errors of the runtime.

use std::path::PathBuf;

/// Everything that running a controller on a machine can fail with.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RuntimeError {
    /// A file cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// The connection to the machine fails.
    #[error("bus {bus}: expected {expected}, got {got}")]
    Bus {
        /// The bus as it was named.
        bus: String,
        /// Expected answer, and what to do.
        expected: String,
        /// Actual answer.
        got: String,
    },
    /// The machine is not the one of the controller.
    #[error("the machine is not the one that the controller was made for:\n  {0}")]
    Refused(String),
    /// A configuration is out of range.
    #[error("{key}: expected {expected}, got {got}")]
    Config {
        /// The key.
        key: String,
        /// Expected value.
        expected: String,
        /// Actual value.
        got: String,
    },
    /// A record is damaged, or not one of this program.
    #[error("{path}: expected {expected}, got {got}")]
    Record {
        /// The file.
        path: PathBuf,
        /// Expected content.
        expected: String,
        /// Actual content.
        got: String,
    },
    /// The controller or the robot is the problem.
    #[error(transparent)]
    Robot(#[from] lifelike_robot::RobotError),
    /// A clip is the problem.
    #[error(transparent)]
    Motion(#[from] lifelike_motion::MotionError),
    /// An array file is the problem.
    #[error(transparent)]
    Checkpoint(#[from] lifelike_checkpoint::CheckpointError),
}

impl RuntimeError {
    pub(crate) fn io(path: &std::path::Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Io { path, source }
    }

    pub(crate) fn config(key: &str, expected: &str, got: impl std::fmt::Display) -> Self {
        Self::Config { key: key.into(), expected: expected.into(), got: got.to_string() }
    }
}
