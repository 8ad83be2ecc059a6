//! The crate's error.

use std::path::PathBuf;

use lifelike_character::CharacterError;
use lifelike_motion::MotionError;

/// A failure of reading, making or checking captioned motion.
#[derive(Debug, thiserror::Error)]
pub enum LanguageError {
    /// A file or an input that cannot be used.
    #[error(transparent)]
    Input(#[from] lifelike_checkpoint::InputError),
    /// A line of a text that is not what it must be.
    #[error("{path}:{line}: {message}")]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// `expected X, got Y`.
        message: String,
    },
    /// A folder in which there is nothing to resume.
    #[error("{folder}: expected an unfinished data set to resume, got {got}")]
    NothingToResume {
        /// The folder.
        folder: PathBuf,
        /// The data set that is there, and the remedy.
        got: &'static str,
    },
    /// A grammar that contradicts itself, or names what is not there.
    #[error("grammar: {0}")]
    Grammar(String),
    /// A command that reads sentences, and fails or writes something else than a script.
    #[error("reader '{command}': {message}")]
    Reader {
        /// The command.
        command: String,
        /// Description of the failure.
        message: String,
    },
    /// A clip or a character that cannot be used.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// A character that is not as it must be.
    #[error(transparent)]
    Character(#[from] CharacterError),
}

impl LanguageError {
    /// Returns the error of a line (from 1) of a file.
    pub fn line(path: impl Into<PathBuf>, line: usize, message: impl Into<String>) -> Self {
        Self::Line { path: path.into(), line, message: message.into() }
    }
}
