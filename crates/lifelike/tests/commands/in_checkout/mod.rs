//! The command, run in the checkout.

#![allow(dead_code)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// Runs the command.
pub fn lifelike(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lifelike")).args(arguments).current_dir(root()).output().unwrap()
}

/// The checkout.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// What it prints.
pub fn out(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// What it says beside.
pub fn err(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Its result as JSON; it must have worked.
pub fn json(arguments: &[&str]) -> Value {
    let output = lifelike(&[&["--json"], arguments].concat());
    assert!(output.status.success(), "{arguments:?}: {}", err(&output));
    serde_json::from_str(&out(&output)).unwrap()
}

/// Its exit code and what it says.
pub fn refused(arguments: &[&str]) -> (i32, String) {
    let output = lifelike(arguments);
    (output.status.code().unwrap(), err(&output))
}

/// Our own clips on Lima, in a folder of the test's.
pub fn retargeted(folder: &Path) -> Value {
    json(&["motion", "retarget", "motions/wave.keys.toml", "motions/nod.keys.toml", "-o", folder.to_str().unwrap()])
}

/// A plan of a tracker that learns nothing in a moment.
pub const TINY: &str = include_str!("tiny.toml");
