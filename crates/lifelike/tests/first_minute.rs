//! The places where somebody new gave up: without data, with a robot of their own, from a folder of their own.

#![cfg(feature = "learning")]
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

/// A training of a second.
const TINY: [&str; 4] = ["ppo.environments=16", "ppo.minibatch=96", "budget.steps=192", "network.actor=[16]"];

/// A folder of somebody's own, with a robot of their own in it.
struct Desk(TempDir);

impl Desk {
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        std::fs::create_dir_all(desk.path("my robots")).unwrap();
        for (from, to) in [("lima.xml", "bot 1.xml"), ("lima.toml", "bot 1.toml")] {
            std::fs::copy(root().join("robots").join(from), desk.path("my robots").join(to)).unwrap();
        }
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn run(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_lifelike")).args(arguments).current_dir(self.0.path()).output().unwrap()
    }

    /// What a command that must work prints.
    fn out(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }

    fn json(&self, arguments: &[&str]) -> Value {
        serde_json::from_str(&self.out(&[&["--json"], arguments].concat())).unwrap()
    }

    /// What a command that must be refused as bad input says.
    fn refused(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert_eq!(output.status.code(), Some(3), "{arguments:?}");
        String::from_utf8(output.stderr).unwrap()
    }

    /// Pastes a line into a shell.
    fn paste(&self, line: &str) {
        let program = Path::new(env!("CARGO_BIN_EXE_lifelike")).parent().unwrap();
        let path = std::env::join_paths(
            std::iter::once(program.to_path_buf()).chain(std::env::split_paths(&std::env::var_os("PATH").unwrap())),
        );
        let output =
            Command::new("sh").args(["-c", line]).env("PATH", path.unwrap()).current_dir(self.0.path()).output();
        let output = output.unwrap();
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    }

    /// Pastes every next step of an inspection; trainings are cut short.
    fn follow(&self, what: &str) -> usize {
        let steps = self.json(&["inspect", what])["next"].as_array().unwrap().clone();
        for step in &steps {
            let step = step.as_str().unwrap();
            assert!(self.out(&["inspect", what]).contains(step), "people see it too: {step}");
            let short = if step.contains("train ") { format!("{step} {}", quoted(&TINY)) } else { step.to_string() };
            let short = short.replace("budget.minutes=5", "");
            // A finished run has nothing left to do; more than its budget would be another test.
            self.paste(&if step.contains("--resume") { step.to_string() } else { short });
        }
        steps.len()
    }
}

fn quoted(words: &[&str]) -> String {
    words.iter().map(|word| format!("'{word}'")).collect::<Vec<_>>().join(" ")
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

#[test]
fn the_next_command_of_a_training_works_for_a_robot_of_ones_own() {
    let desk = Desk::new();
    let arguments = ["train", "tracker", "--plan", "track", "-o", "my runs/a", "robot=my robots/bot 1.xml"];
    let clips = ["clips=['builtin:nod', 'builtin:wave']"];
    let printed = desk.out(&[&arguments[..], &clips, &TINY].concat());
    let next = printed.lines().find_map(|line| line.strip_prefix("next:")).unwrap().trim();
    assert!(next.contains("--robot 'my robots/bot 1.xml' --motions builtin:nod builtin:wave"), "{next}");
    desk.paste(next);
    assert!(desk.path("my runs/a/evaluation/report.html").is_file());
    assert_eq!(desk.follow("my runs/a"), 2, "a run has its evaluation and its resumption");
}

#[test]
fn plans_are_there_after_an_install_and_need_no_data() {
    let desk = Desk::new();
    let listed = desk.out(&["plans"]);
    assert!(listed.contains("track-walk") && listed.contains("train prior"), "{listed}");
    for name in ["track", "experiments/track.toml"] {
        desk.out(&[&["train", "tracker", "--plan", name, "-o", "run"], &TINY[..]].concat());
        let clips = &desk.json(&["inspect", "run"])["plan"]["clips"];
        assert_eq!(*clips, serde_json::json!(["builtin"]));
        std::fs::remove_dir_all(desk.path("run")).unwrap();
    }
    std::fs::write(desk.path("my.toml"), desk.out(&["plans", "track"])).unwrap();
    desk.out(&[&["train", "tracker", "--plan", "my.toml", "-o", "run"], &TINY[..]].concat());
    let unknown = desk.refused(&["train", "tracker", "--plan", "trakc"]);
    assert!(unknown.contains("'trakc'") && unknown.contains("track-walk"), "{unknown}");
    let unknown = desk.refused(&["motion", "check", "builtin:dance"]);
    assert!(unknown.contains("builtin:dance") && unknown.contains("sway_dance"), "{unknown}");
}

#[test]
fn a_plan_without_its_data_says_how_to_get_it_or_do_without() {
    let desk = Desk::new();
    let error = desk.refused(&["train", "tracker", "--plan", "track-walk", "-o", "run"]);
    for part in ["data/lima/deepmimic", "lifelike motion retarget CAPTURES --robot lima", "'clips=[\"builtin\"]'"] {
        assert!(error.contains(part), "{part}: {error}");
    }
    assert!(!desk.path("run").exists(), "nothing was started");
    desk.out(&[&["train", "tracker", "--plan", "track-walk", "-o", "run", "clips=[\"builtin\"]"], &TINY[..]].concat());
    let error = desk.refused(&["train", "spline", "--plan", "spline-lima", "-o", "spline"]);
    assert!(error.contains("'clips=[\"builtin\"]' 'validation=[]' 'test=[]'"), "{error}");
}

#[test]
fn a_plans_paths_begin_at_its_file_and_those_of_the_command_line_where_one_is() {
    let desk = Desk::new();
    std::fs::create_dir_all(desk.path("project/plans")).unwrap();
    std::fs::create_dir_all(desk.path("project/data")).unwrap();
    std::fs::copy(root().join("motions/nod.keys.toml"), desk.path("project/data/nod.keys.toml")).unwrap();
    let plan = "robot = '../../my robots/bot 1.xml'\nclips = ['data/nod.keys.toml']\n";
    std::fs::write(desk.path("project/plans/a.toml"), plan).unwrap();
    desk.out(&[&["train", "tracker", "--plan", "project/plans/a.toml", "-o", "run"], &TINY[..]].concat());
    let changed = "clips=['project/data']";
    desk.out(&[&["train", "tracker", "--plan", "project/plans/a.toml", "-o", "two", changed], &TINY[..]].concat());
}

#[test]
fn an_inspection_ends_with_steps_that_work() {
    let desk = Desk::new();
    assert_eq!(desk.follow("lima"), 2);
    assert_eq!(desk.follow("my robots/bot 1.xml"), 2);
    std::fs::copy(root().join("motions/wave.keys.toml"), desk.path("it's a wave.keys.toml")).unwrap();
    assert_eq!(desk.follow("it's a wave.keys.toml"), 1);
    assert_eq!(desk.follow("data/lima/it_s_a_wave.motion.safetensors"), 3);
    for asset in ["lima-path.policy", "lima.prior"] {
        let file = root().join(format!("assets/{asset}.safetensors"));
        assert_eq!(desk.follow(file.to_str().unwrap()), 1, "{asset}");
    }
}

#[test]
fn every_key_of_a_plan_is_told_with_meaning_and_default() {
    let desk = Desk::new();
    let text = desk.out(&["train", "tracker", "--keys"]);
    for part in ["ppo.gamma", "0.97", "budget.minutes", "reward.joint_position", "randomization.pushes"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let keys = desk.json(&["train", "tracker", "--keys"]);
    let keys = keys.as_array().unwrap();
    assert!(keys.len() > 60, "{}", keys.len());
    assert!(keys.iter().all(|key| !key["meaning"].as_str().unwrap().is_empty()), "{keys:?}");
}
