//! The parts of `cargo xtask`. Errors are sentences: whoever reads them is a person at a terminal.

pub mod build;
pub mod fetch;
pub mod mujoco;
pub mod text_model;
pub mod wheel;

use std::path::{Path, PathBuf};

/// The folder of the workspace.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map_or_else(|| PathBuf::from("."), Path::to_path_buf)
}

/// Prefixes an I/O error with the path it is about.
pub fn at<E: std::fmt::Display>(path: &Path) -> impl FnOnce(E) -> String {
    move |error| format!("{}: {error}", path.display())
}
