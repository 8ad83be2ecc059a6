//! The two commands of the README: the demo, and the tests.

use std::path::Path;
use std::process::Command;

use lifelike_fetch::mujoco;

use crate::{fetch, root, third_party};

/// `cargo xtask demo [ARGUMENTS]`: needs nothing but cargo.
///
/// # Errors
/// When the build fails or the demo does.
pub fn demo(arguments: &[String]) -> Result<(), String> {
    let package = ["run", "--release", "--package", "lifelike"];
    cargo(None, &[&package[..], &["--bin", "lifelike", "--", "demo"]].concat(), arguments)
}

/// `cargo xtask test [ARGUMENTS]`: every test. MuJoCo and the robots that are measured are fetched for it.
///
/// # Errors
/// When a test fails, or MuJoCo or a robot cannot be had.
pub fn test(arguments: &[String]) -> Result<(), String> {
    let library = mujoco::ensure(&third_party())?;
    let library = Some(library.as_path());
    // The gates measure these models; meshes are not needed.
    lifelike_fetch::NAMES.iter().try_for_each(|name| fetch(name, false))?;
    let command = ["test", "--release", "--workspace"];
    let chosen = ["--lib", "--bin", "--bins", "--test", "--tests", "--example", "--examples", "--doc", "--all-targets"];
    if arguments.iter().any(|argument| chosen.contains(&argument.as_str())) {
        return cargo(library, &command, arguments);
    }
    // Examples have no tests: clippy compiles them (`.ci/run lint`).
    let tests = cargo(library, &[&command[..], &["--lib", "--bins", "--tests"]].concat(), arguments);
    if tests.is_err() && !arguments.iter().any(|argument| argument == "--no-fail-fast") {
        return tests;
    }
    tests.and(cargo(library, &[&command[..], &["--doc"]].concat(), arguments))
}

fn cargo(library: Option<&Path>, command: &[&str], arguments: &[String]) -> Result<(), String> {
    let program = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let said = command.iter().copied().chain(arguments.iter().map(String::as_str)).collect::<Vec<_>>().join(" ");
    eprintln!("cargo {said}");
    let mut cargo = Command::new(program);
    cargo.args(command).args(arguments).current_dir(root());
    if let Some(library) = library {
        cargo.env("LIFELIKE_MUJOCO", library);
    }
    let status = cargo.status().map_err(|e| format!("cannot run cargo: {e}"))?;
    if status.success() { Ok(()) } else { Err(format!("`cargo {said}` failed ({status})")) }
}
