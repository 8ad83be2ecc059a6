//! Errors of text to motion.

use std::path::{Path, PathBuf};

/// Errors of text to motion.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GenerationError {
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
    /// A prompt that is no sentence.
    #[error("prompt: expected {expected}, got {got}")]
    Prompt {
        /// The accepted form.
        expected: String,
        /// The text found.
        got: String,
    },
    /// A file of a text model that cannot be used.
    #[error("{path}: {why}")]
    TextModel {
        /// The file.
        path: PathBuf,
        /// The reason.
        why: String,
    },
}

impl GenerationError {
    /// Returns the error of two things that do not fit.
    pub(crate) fn mismatch(what: impl Into<String>, expected: impl ToString, got: impl ToString) -> Self {
        Self::Mismatch { what: what.into(), expected: expected.to_string(), got: got.to_string() }
    }

    /// Returns the error of a text model's file.
    pub(crate) fn text_model(path: &Path, why: impl ToString) -> Self {
        Self::TextModel { path: path.to_owned(), why: why.to_string() }
    }

    /// Returns the error of a prompt.
    pub(crate) fn prompt(expected: impl ToString, got: impl ToString) -> Self {
        Self::Prompt { expected: expected.to_string(), got: got.to_string() }
    }
}
