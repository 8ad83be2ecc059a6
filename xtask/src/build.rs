//! The two commands of the README: everything set up, then the demo or the tests.

use std::ffi::OsString;
use std::path::Path;
use std::process::Command;

use crate::{mujoco, root};

/// `cargo xtask demo [ARGUMENTS]`.
///
/// # Errors
/// When MuJoCo cannot be had, the build fails or the demo does.
pub fn demo(arguments: &[String]) -> Result<(), String> {
    let library = mujoco::ensure()?;
    let command =
        ["run", "--release", "--package", "lifelike", "--features", "mujoco", "--bin", "lifelike", "--", "demo"];
    cargo(&library, &command, arguments)
}

/// `cargo xtask test [ARGUMENTS]`.
///
/// # Errors
/// When MuJoCo cannot be had, or a test fails.
pub fn test(arguments: &[String]) -> Result<(), String> {
    let library = mujoco::ensure()?;
    cargo(&library, &["test", "--release", "--workspace", "--features", "lifelike/mujoco"], arguments)
}

fn cargo(library: &Path, command: &[&str], arguments: &[String]) -> Result<(), String> {
    let program = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let said = command.iter().copied().chain(arguments.iter().map(String::as_str)).collect::<Vec<_>>().join(" ");
    eprintln!("cargo {said}");
    let status = Command::new(program)
        .args(command)
        .args(arguments)
        .current_dir(root())
        .env("MUJOCO_DYNAMIC_LINK_DIR", library)
        .env(LOADER_PATH, with_first(library, std::env::var_os(LOADER_PATH)))
        .status()
        .map_err(|e| format!("cannot run cargo: {e}"))?;
    if status.success() { Ok(()) } else { Err(format!("`cargo {said}` failed ({status})")) }
}

/// Where the system's loader looks for libraries.
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
