//! Errors of the data of chapter 3.

use std::path::{Path, PathBuf};

use lifelike::CliError;
use lifelike_train::PlanError;

/// Errors of the data of chapter 3.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SequencesError {
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

impl SequencesError {
    /// Returns a closure for `map_err` on file operations.
    pub fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Io { path, source }
    }
}

impl From<SequencesError> for CliError {
    fn from(error: SequencesError) -> Self {
        match error {
            SequencesError::Io { ref source, .. } => Self::io(source, error.to_string()),
            SequencesError::Representation(error) => error.into(),
            _ => Self::Input(error.to_string()),
        }
    }
}
