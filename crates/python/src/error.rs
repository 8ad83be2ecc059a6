//! One exception for everything that is wrong with an input, with the text of the command.

use std::fmt::Display;
use std::sync::Once;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use tracing_subscriber::filter::LevelFilter;

pyo3::create_exception!(
    lifelike,
    Error,
    PyValueError,
    "Input that cannot be used, or an operation that failed. The text is that of the command `lifelike`."
);

/// Conversion of our errors into [`Error`].
pub trait Raise<T> {
    /// Returns the value, or raises the error's text.
    fn or_raise(self) -> PyResult<T>;
}

impl<T, E: Display> Raise<T> for Result<T, E> {
    fn or_raise(self) -> PyResult<T> {
        self.map_err(|error| Error::new_err(error.to_string()))
    }
}

/// Prints warnings of the libraries on standard error, as the command does. The command sets up its own log instead.
pub fn show_warnings() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let lines = tracing_subscriber::fmt().with_writer(std::io::stderr).with_target(false).without_time();
        // A host program with a subscriber of its own keeps it.
        let _ = lines.with_max_level(LevelFilter::WARN).try_init();
    });
}
