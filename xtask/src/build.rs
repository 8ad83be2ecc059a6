//! The two commands of the README: the demo, and the tests.

use std::ffi::OsString;
use std::path::Path;
use std::process::Command;

use crate::{fetch, mujoco, root};

/// `cargo xtask demo [ARGUMENTS]`: needs nothing but cargo.
///
/// # Errors
/// When the build fails or the demo does.
pub fn demo(arguments: &[String]) -> Result<(), String> {
    let package = ["run", "--release", "--package", "lifelike"];
    cargo(None, &[&package[..], &["--bin", "lifelike", "--", "demo"]].concat(), arguments)
}

/// `cargo xtask test [--mujoco] [ARGUMENTS]`: every test; with `--mujoco` also those that compare our physics with
/// MuJoCo's. MuJoCo and the robots that are measured are fetched for it.
///
/// # Errors
/// When a test fails, or MuJoCo is wanted and it or a robot cannot be had.
pub fn test(arguments: &[String]) -> Result<(), String> {
    let (library, rest) = match arguments.split_first() {
        Some((first, rest)) if first == "--mujoco" => {
            let library = mujoco::ensure()?;
            // The gates measure these models; meshes are not needed.
            lifelike_fetch::NAMES.iter().try_for_each(|name| fetch(name, false))?;
            (Some(library), rest)
        }
        _ => (None, arguments),
    };
    let mut command = vec!["test", "--release", "--workspace"];
    if library.is_some() {
        command.extend(["--features", "lifelike/mujoco"]);
    }
    let library = library.as_deref();
    let chosen = ["--lib", "--bin", "--bins", "--test", "--tests", "--example", "--examples", "--doc", "--all-targets"];
    if rest.iter().any(|argument| chosen.contains(&argument.as_str())) {
        return cargo(library, &command, rest);
    }
    // Examples have no tests: clippy compiles them (`.ci/run lint`).
    let tests = cargo(library, &[&command[..], &["--lib", "--bins", "--tests"]].concat(), rest);
    if tests.is_err() && !rest.iter().any(|argument| argument == "--no-fail-fast") {
        return tests;
    }
    tests.and(cargo(library, &[&command[..], &["--doc"]].concat(), rest))
}

fn cargo(library: Option<&Path>, command: &[&str], arguments: &[String]) -> Result<(), String> {
    let program = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let said = command.iter().copied().chain(arguments.iter().map(String::as_str)).collect::<Vec<_>>().join(" ");
    eprintln!("cargo {said}");
    let mut cargo = Command::new(program);
    cargo.args(command).args(arguments).current_dir(root());
    if let Some(library) = library {
        cargo.env("MUJOCO_DYNAMIC_LINK_DIR", library);
        cargo.env(LOADER_PATH, with_first(library, std::env::var_os(LOADER_PATH)));
    }
    let status = cargo.status().map_err(|e| format!("cannot run cargo: {e}"))?;
    if status.success() { Ok(()) } else { Err(format!("`cargo {said}` failed ({status})")) }
}

/// Variable that the system's loader finds libraries by.
const LOADER_PATH: &str = if cfg!(target_os = "macos") { "DYLD_LIBRARY_PATH" } else { "LD_LIBRARY_PATH" };

fn with_first(library: &Path, others: Option<OsString>) -> OsString {
    let mut path = library.as_os_str().to_owned();
    if let Some(others) = others.filter(|o| !o.is_empty()) {
        path.push(":");
        path.push(others);
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn our_library_comes_first_and_nothing_is_lost() {
        assert_eq!(with_first(Path::new("/a"), Some("/b:/c".into())), "/a:/b:/c");
        assert_eq!(with_first(Path::new("/a"), None), "/a");
        // An empty entry would mean the working directory.
        assert_eq!(with_first(Path::new("/a"), Some("".into())), "/a");
    }
}
