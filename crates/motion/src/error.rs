//! Errors of motion data.

use std::path::PathBuf;

/// Everything that reading, converting or using motion can fail with.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MotionError {
    /// A file or an input that cannot be used.
    #[error(transparent)]
    Input(#[from] lifelike_checkpoint::InputError),
    /// The content is not what it should be.
    #[error("{file}:{line}: expected {expected}, got {got}")]
    Parse {
        /// The file.
        file: PathBuf,
        /// Line, counted from 1.
        line: usize,
        /// Expected content.
        expected: String,
        /// Actual content.
        got: String,
    },
    /// A clip and a character do not fit together.
    #[error("clip '{clip}' does not fit character '{character}': {message}")]
    Mismatch {
        /// The clip.
        clip: String,
        /// The character.
        character: String,
        /// Names that are missing or unknown.
        message: String,
    },
    /// The clip cannot be used for this.
    #[error("clip '{clip}': {message}")]
    Unfit {
        /// The clip.
        clip: String,
        /// Cause.
        message: String,
    },
    /// The character itself is the problem.
    #[error(transparent)]
    Character(#[from] lifelike_character::CharacterError),
}
