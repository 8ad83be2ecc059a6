//! The build without the training framework: what it has works, what it lacks is said.

#![cfg(not(feature = "learning"))]
#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::process::{Command, Output};

fn lifelike(arguments: &[&str]) -> Output {
    let folder = std::env::temp_dir();
    Command::new(env!("CARGO_BIN_EXE_lifelike")).args(arguments).current_dir(folder).output().unwrap()
}

#[test]
fn what_learns_is_refused_with_how_to_get_it() {
    for arguments in [
        &["train", "tracker", "--plan", "track"][..],
        &["motion", "edit", "a.keys.toml", "--spline", "s", "-o", "x"],
        &["motion", "search", "--help"],
        &["bench", "curves", "-o", "x"],
        &["--json", "bench", "learning"],
    ] {
        let output = lifelike(arguments);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(4), "{arguments:?}: {error}");
        assert!(error.contains("cargo install --path crates/lifelike"), "{error}");
    }
}

#[test]
fn robots_motion_physics_and_policies_are_there() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let policy = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/lima-path.policy.safetensors");
    for arguments in [
        &["robots"][..],
        &["plans"],
        &["inspect", "lima"],
        &["motion", "check", "builtin:walk"],
        &["motion", "trim", "builtin:wave", "--end", "2", "-o", out],
        &["bench", "engine", "--environments", "16", "--seconds", "0.01"],
        &["demo", "-o", out],
        &["eval", "--policy", policy.to_str().unwrap(), "--motions", "builtin:wave", "--starts", "1", "-o", out],
        &["inspect", policy.to_str().unwrap()],
    ] {
        let output = lifelike(arguments);
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    }
}
