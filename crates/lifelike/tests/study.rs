//! A promise: a study may be trained variant by variant, and says of what is trained the same as if it were whole.

#![cfg(feature = "learning")]
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::Path;
use std::process::Command;

const PLAN: &str = r#"
robot = "lima"
clips = ["motions/nod.keys.toml"]
[budget]
steps = 64
[network]
actor = [8]
critic = [8]
[ppo]
environments = 4
steps = 8
minibatch = 16
"#;

/// The second stage begins with the first one's networks.
const STUDY: &str = r#"
plan = "plan.toml"
starts = 1
seconds = 0.4
[[stage]]
name = "first"
[[stage]]
name = "second"
[[variant]]
name = "A"
seeds = [1]
[[variant]]
name = "B"
seeds = [1]
[[class]]
name = "nod"
clips = ["motions/nod.keys.toml"]
"#;

fn variants(folder: &Path, more: &[&str]) -> Vec<String> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lifelike"));
    command.current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."));
    command.args(["--quiet", "--json", "bench", "tracking", "--threads", "1", "--study"]);
    let out = command.arg(folder.join("study.toml")).arg("-o").arg(folder.join("runs")).args(more).output().unwrap();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let runs: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    let name = |run: &serde_json::Value| format!("{} {}", run["variant"], run["stage"]).replace('"', "");
    runs.as_array().unwrap().iter().map(name).collect()
}

#[test]
fn variants_are_trained_one_by_one_whatever_the_others_have_not_begun() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("plan.toml"), PLAN).unwrap();
    std::fs::write(folder.path().join("study.toml"), STUDY).unwrap();
    // A comes first and has nothing yet to begin its second stage with.
    assert_eq!(variants(folder.path(), &["--only", "B"]), ["B first", "B second"]);
    assert_eq!(variants(folder.path(), &["--only", "A"]), ["A first", "A second", "B first", "B second"]);
}
