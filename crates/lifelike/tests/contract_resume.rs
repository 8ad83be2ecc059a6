//! A promise: a training run that is killed at any moment, even inside a save, goes on as if nothing had happened, and
//! Ctrl-C loses nothing. Real processes, real signals, byte for byte.
//!
//! `LIFELIKE_KILLS` sets how often the run is killed (6 where not set).

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Saves after every iteration, so that kills often fall into a save.
const PLAN: &str = r#"
robot = "lima"
clips = ["motions/nod.keys.toml", "motions/wave.keys.toml"]
seed = 3
checkpoint_every = 1
[budget]
steps = 9600
[network]
actor = [16]
critic = [16]
[ppo]
environments = 4
steps = 8
minibatch = 16
epochs = 2
"#;

const FILES: [&str; 2] = ["metrics.jsonl", "tracker.controller.safetensors"];

fn start(plan: &Path, run: &Path) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lifelike"));
    command.current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."));
    command.args(["--quiet", "train", "tracker", "--threads", "1", "-o"]).arg(run);
    if run.join("plan.toml").exists() {
        command.arg("--resume");
    } else {
        command.arg("--plan").arg(plan);
    }
    command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

fn finish(child: Child) {
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn setup(folder: &Path) -> (PathBuf, PathBuf, Duration) {
    let plan = folder.join("plan.toml");
    std::fs::write(&plan, PLAN).unwrap();
    let whole = folder.join("whole");
    let began = Instant::now();
    finish(start(&plan, &whole));
    (plan, whole, began.elapsed())
}

/// Whether a save was cut off: its temporary file is still there, or its checkpoint without the text that seals it.
fn half_saved(checkpoints: &Path) -> bool {
    let Ok(entries) = std::fs::read_dir(checkpoints) else { return false };
    let names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    let count = |end: &str| names.iter().filter(|n| n.ends_with(end)).count();
    names.iter().any(|n| n.contains("partial")) || count(".safetensors") != count(".json")
}

fn assert_same(whole: &Path, other: &Path) {
    for file in FILES {
        let (a, b) = (std::fs::read(whole.join(file)).unwrap(), std::fs::read(other.join(file)).unwrap());
        assert!(!a.is_empty() && a == b, "{file} differs from the uninterrupted run's");
    }
}

#[test]
fn a_run_killed_at_any_moment_goes_on_to_the_same_bytes() {
    let kills: u32 = std::env::var("LIFELIKE_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(6);
    let folder = tempfile::tempdir().unwrap();
    let (plan, whole, time) = setup(folder.path());
    let killed = folder.path().join("killed");
    let (mut inside, mut saving) = (0, 0);
    for i in 0..kills {
        let mut child = start(&plan, &killed);
        // Golden-ratio steps: spread evenly over the first parts of a run, never the same moment twice.
        let share = (f64::from(i) * 0.618_034).fract();
        std::thread::sleep(time.mul_f64((0.05 + 0.4 * share) / f64::from(kills).sqrt()));
        let running = child.try_wait().unwrap().is_none();
        child.kill().unwrap();
        child.wait().unwrap();
        inside += u32::from(running && killed.join("metrics.jsonl").exists());
        saving += u32::from(running && half_saved(&killed.join("checkpoints")));
    }
    assert!(inside > 0, "no kill fell into the training: nothing was tested");
    finish(start(&plan, &killed));
    assert_same(&whole, &killed);
    println!(
        "killed {kills} times, {inside} of them in the training of {:.1} s, {saving} of these inside a save; same bytes",
        time.as_secs_f64()
    );
}

#[test]
fn ctrl_c_saves_says_so_and_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (plan, whole, _) = setup(folder.path());
    let stopped = folder.path().join("stopped");
    let child = start(&plan, &stopped);
    let metrics = stopped.join("metrics.jsonl");
    let deadline = Instant::now() + Duration::from_secs(120);
    while std::fs::read_to_string(&metrics).map_or(0, |t| t.lines().count()) < 5 {
        assert!(Instant::now() < deadline, "the training never began");
        std::thread::sleep(Duration::from_millis(5));
    }
    let signalled = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(signalled.success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(String::from_utf8_lossy(&output.stderr).contains("--resume"));
    let lines = std::fs::read_to_string(&metrics).unwrap().lines().count();
    assert!((5..300).contains(&lines), "stopped early: {lines} of 300 iterations");
    finish(start(&plan, &stopped));
    assert_same(&whole, &stopped);
}
