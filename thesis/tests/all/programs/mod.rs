//! The program of tables, in the checkout or a folder, and the user's program in this process.

#![allow(dead_code)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// The checkout.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Runs a command of `lifelike` in the checkout, which must work.
#[track_caller]
pub fn lifelike(arguments: &[&str]) {
    // The same for all tests of a process.
    std::env::set_current_dir(root()).unwrap();
    lifelike::run(&[&["--json", "--quiet"], arguments].concat()).unwrap();
}

/// Runs `lifelike-thesis` in a folder.
pub fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lifelike-thesis")).args(arguments).current_dir(folder).output().unwrap()
}

/// Its result as JSON; it must have worked.
#[track_caller]
pub fn json(folder: &Path, arguments: &[&str]) -> Value {
    let output = run(folder, &[&["--json"], arguments].concat());
    assert!(output.status.success(), "{arguments:?}: {}", err(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Its messages.
pub fn err(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// A path in a folder, as an argument.
pub fn at(folder: &Path, name: &str) -> String {
    folder.join(name).to_str().unwrap().to_owned()
}

/// A clip of the checkout, as an argument.
pub fn keys(name: &str) -> String {
    at(&root(), &format!("motions/{name}.keys.toml"))
}
