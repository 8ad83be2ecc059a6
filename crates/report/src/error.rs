//! Errors of run folders and reports.

use std::path::{Path, PathBuf};

/// Errors of run folders and reports.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
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
    /// The browser that draws a page fails.
    #[error("browser: {what}: {reason}")]
    Browser {
        /// The method, address or expression.
        what: String,
        /// The reason.
        reason: String,
    },
}

impl ReportError {
    /// Returns a closure for `map_err` on file operations.
    pub fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Io { path, source }
    }
}
