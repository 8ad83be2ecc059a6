//! Errors of run folders and reports.

/// Errors of run folders and reports.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A file or an input that cannot be used.
    #[error(transparent)]
    Input(#[from] lifelike_checkpoint::InputError),
    /// The browser that draws a page fails.
    #[error("browser: {what}: {reason}")]
    Browser {
        /// The method, address or expression.
        what: String,
        /// The reason.
        reason: String,
    },
}
