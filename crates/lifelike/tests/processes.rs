//! What several processes promise, started by MPI itself.
#![cfg(feature = "mpi")]
#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::process::Command;

/// Standing still: no clips to fetch, everything else as in a real training. The minibatch is everything.
fn plan(environments: usize) -> String {
    format!(
        "robot = \"lima\"\nclips = []\n[budget]\nsteps = 1536\n[network]\nactor = [32]\ncritic = [32]\n\
         [rsi]\nfailure_share = 0.0\n[ppo]\nenvironments = {environments}\nsteps = 8\nepochs = 2\nminibatch = {}\n",
        8 * environments
    )
}

fn losses(folder: &Path) -> Vec<(f64, f64)> {
    let text = std::fs::read_to_string(folder.join("metrics.jsonl")).unwrap();
    let rows = text.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
    rows.map(|row| (row["Loss/value_function"].as_f64().unwrap(), row["Loss/kl"].as_f64().unwrap())).collect()
}

fn train(launcher: &[&str], folder: &Path, environments: usize) -> Vec<(f64, f64)> {
    let file = folder.with_extension("toml");
    std::fs::write(&file, plan(environments)).unwrap();
    let program = env!("CARGO_BIN_EXE_lifelike");
    let mut words: Vec<&str> = launcher.to_vec();
    words.push(program);
    let done = Command::new(words[0])
        .args(&words[1..])
        .args(["train", "tracker", "--quiet", "--threads", "1", "--plan"])
        .arg(&file)
        .arg("-o")
        .arg(folder)
        .output()
        .unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    losses(folder)
}

#[test]
fn two_processes_have_the_losses_of_one_with_twice_the_environments() {
    let place = tempfile::tempdir().unwrap();
    let one = train(&[], &place.path().join("one"), 32);
    let launcher = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", "2"];
    let two = train(&launcher, &place.path().join("two"), 16);
    assert_eq!((one.len(), two.len()), (6, 6));
    for (i, (one, two)) in one.iter().zip(&two).enumerate() {
        for (a, b) in [(one.0, two.0), (one.1, two.1)] {
            assert!((a - b).abs() <= 1e-3 * a.abs() + 1e-7, "iteration {i}: {a} alone, {b} in two processes");
        }
    }
    assert!(one[5].0 != one[0].0);
}
