//! What can be wrong with a robot's description, or with what is handed to it.

use std::path::PathBuf;

/// Everything that making or using a robot can fail with.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RobotError {
    /// The file cannot be read.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The profile is not what it should be.
    #[error("{path}: {message}")]
    Profile {
        /// The file.
        path: PathBuf,
        /// What is wrong, with line and key.
        message: String,
    },
    /// No robot of this name.
    #[error("no robot named '{name}': not a file, and not one of {available}")]
    Unknown {
        /// The name.
        name: String,
        /// The built-in ones.
        available: String,
    },
    /// Two things that must carry the same names do not.
    #[error("{what}: expected {expected}, got {got}")]
    Mismatch {
        /// What was compared.
        what: String,
        /// What should be there.
        expected: String,
        /// What is there.
        got: String,
    },
    /// The robot cannot be controlled, or its description contradicts itself.
    #[error("robot '{robot}': {message}")]
    Unfit {
        /// The robot.
        robot: String,
        /// What is wrong, with names.
        message: String,
    },
    /// The character itself is the problem.
    #[error(transparent)]
    Character(#[from] lifelike_character::CharacterError),
}
