//! Three errors that every crate has: a file, its form, and two things that do not fit.

use std::io;
use std::path::{Path, PathBuf};

/// Input that cannot be used; the crates' own errors contain it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    /// A file cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: io::Error,
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
}

/// Short constructors of every error that contains an [`InputError`].
pub trait FromInput: From<InputError> {
    /// Returns a closure for `map_err` on file operations.
    fn io(path: &Path) -> impl Fn(io::Error) -> Self + Copy {
        move |source| InputError::Io { path: path.into(), source }.into()
    }

    /// Returns the error of a file in another form.
    fn format(path: impl ToString, expected: impl ToString, got: impl ToString) -> Self {
        let [path, expected, got] = [path.to_string(), expected.to_string(), got.to_string()];
        InputError::Format { path, expected, got }.into()
    }

    /// Returns the error of two things that do not fit.
    fn mismatch(what: impl ToString, expected: impl ToString, got: impl ToString) -> Self {
        let [what, expected, got] = [what.to_string(), expected.to_string(), got.to_string()];
        InputError::Mismatch { what, expected, got }.into()
    }
}

impl<E: From<InputError>> FromInput for E {}
