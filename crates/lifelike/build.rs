//! Says which version this is: commit and features.

use std::process::Command;

/// Optional features that `--version` names.
const FEATURES: [&str; 2] = ["dds", "mpi"];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=LIFELIKE_COMMIT");
    println!("cargo::rustc-env=LIFELIKE_VERSION={}", version());
}

/// Version, commit and features, as in `0.1.0 (23f8333; mpi)`. The commit is LIFELIKE_COMMIT, or that of the checkout when this
/// was last run: a new commit alone compiles nothing anew.
fn version() -> String {
    let commit = std::env::var("LIFELIKE_COMMIT").ok().or_else(|| {
        let git = Command::new("git").args(["rev-parse", "--short", "HEAD"]).output().ok()?;
        git.status.success().then(|| String::from_utf8_lossy(&git.stdout).trim().to_owned())
    });
    let is_on = |name: &&str| std::env::var_os(format!("CARGO_FEATURE_{}", name.to_uppercase())).is_some();
    let features: Vec<&str> = FEATURES.into_iter().filter(is_on).collect();
    let number = std::env::var("CARGO_PKG_VERSION").unwrap_or_default();
    let features = if features.is_empty() { "no features".to_owned() } else { features.join(", ") };
    format!("{number} ({}; {features})", commit.unwrap_or_else(|| "no commit".to_owned()))
}
