//! The parts of `cargo xtask`. Errors are sentences: whoever reads them is a person at a terminal.

pub mod build;
pub mod dist;
pub mod docs;

use std::path::{Path, PathBuf};

/// The folder of the workspace.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map_or_else(|| PathBuf::from("."), Path::to_path_buf)
}

/// Folder of what is fetched.
pub fn third_party() -> PathBuf {
    root().join("third_party")
}

/// Fetches somebody else's robot into `third_party/robots`.
///
/// # Errors
/// As [`lifelike_fetch::robot`].
pub fn fetch(name: &str, meshes: bool) -> Result<(), String> {
    let profile = include_str!("../../robots/unitree_g1.toml");
    lifelike_fetch::robot(name, meshes, &third_party().join("robots"), profile).map(|_| ())
}
