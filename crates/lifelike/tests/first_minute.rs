//! The places where somebody new gave up: without data, with a robot of their own, from a folder of their own.

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

    /// Pastes a line into a shell; returns what it prints.
    fn paste(&self, line: &str) -> String {
        let program = Path::new(env!("CARGO_BIN_EXE_lifelike")).parent().unwrap();
        let path = std::env::join_paths(
            std::iter::once(program.to_path_buf()).chain(std::env::split_paths(&std::env::var_os("PATH").unwrap())),
        );
        let output =
            Command::new("sh").args(["-c", line]).env("PATH", path.unwrap()).current_dir(self.0.path()).output();
        let output = output.unwrap();
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
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
fn a_training_goes_on_with_a_policy_that_comes_with_the_program() {
    let desk = Desk::new();
    let output = desk.run(
        &[&["train", "tracker", "--plan", "track-long", "-o", "run", "clips=['builtin:nod']"], &TINY[..3]].concat(),
    );
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && told.contains("begins with the policy and the value function of"), "{told}");
    let shipped = root().join("assets/lima-path.controller.safetensors");
    let run = desk.path("run/tracker.controller.safetensors");
    let seen = [&run, &shipped].map(|file| desk.json(&["inspect", file.to_str().unwrap()]));
    assert_eq!(seen[0]["header"]["observation"], seen[1]["header"]["observation"]);
    assert_eq!((&seen[0]["trainable"], &seen[1]["trainable"]), (&true.into(), &true.into()));
    desk.out(&["export", "run"]);
    let exported = desk.json(&["inspect", "run/run.controller.safetensors"]);
    assert_eq!((&exported["trainable"], &exported["header"]), (&false.into(), &seen[0]["header"]));
    let without = ["train", "tracker", "--plan", "track-long", "-o", "other", "clips=['builtin:nod']"];
    let error = desk.refused(&[&without[..], &["init=run/run.controller.safetensors"]].concat());
    assert!(error.contains("expected a controller as training writes it"), "{error}");
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
    for asset in ["lima-path.controller", "lima.prior"] {
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

/// Returns the commands that a result proposes next.
fn proposed(printed: &str) -> Vec<String> {
    let lines = printed.lines().map(|line| line.trim().trim_start_matches("next:").trim());
    lines.filter(|line| line.starts_with("lifelike ")).map(str::to_owned).collect()
}

/// The hour of somebody with a robot that nobody knows and a capture from elsewhere: after the first command, each is copied
/// from what the one before printed. Trainings are cut short, nothing else is changed.
#[test]
fn the_first_hour_by_printed_commands_alone() {
    let desk = Desk::new();
    std::fs::copy(root().join("robots/lima.xml"), desk.path("strider.xml")).unwrap();
    // The skeleton of our smallest capture, upright for a second.
    let capture = std::fs::read_to_string(root().join("crates/motion/src/formats/tests/small.bvh")).unwrap();
    let (skeleton, rows) = capture.split_once("Frames: 2\n").unwrap();
    let numbers = rows.lines().last().unwrap().split_whitespace().count();
    let upright = format!("0 90 0{}\n", " 0".repeat(numbers - 3)).repeat(120);
    std::fs::write(desk.path("walk.bvh"), format!("{skeleton}Frames: 120\nFrame Time: 0.0083333\n{upright}")).unwrap();
    let mut waiting = vec!["lifelike inspect strider.xml".to_string(), "lifelike inspect walk.bvh".to_string()];
    let mut done: Vec<String> = Vec::new();
    while let Some(line) = waiting.pop() {
        // A capture goes to our robot by default; here it goes to the user's own.
        let line = line.replace("--robot lima -o data/lima", "--robot strider.xml -o data/strider");
        if done.contains(&line) || done.len() > 20 {
            continue;
        }
        let short = line.replace("budget.minutes=5", &quoted(&TINY));
        let short = if short.contains("train tracker --plan") && !short.contains("ppo") {
            format!("{short} -o runs/{} {}", done.len(), quoted(&TINY))
        } else {
            short
        };
        let began = std::time::Instant::now();
        let printed = desk.paste(&short);
        println!("{:5.1} s  {short}", began.elapsed().as_secs_f64());
        let next = proposed(&printed);
        done.push(line);
        waiting.extend(next);
    }
    let ran =
        |words: &str| assert!(done.iter().any(|line| line.contains(words)), "{words} is never proposed: {done:#?}");
    for words in ["motion check", "motion retarget walk.bvh", "train tracker", "eval --policy", "--explain"] {
        ran(words);
    }
}

#[test]
fn a_dry_run_prints_plan_speed_and_time_and_writes_nothing() {
    let desk = Desk::new();
    let arguments =
        ["train", "tracker", "--plan", "track", "--robot", "my robots/bot 1.xml", "clips=builtin:nod", "--dry-run"];
    let printed = desk.out(&[&arguments[..], &TINY[..2], &["budget.minutes=7"]].concat());
    for part in
        ["robot = \"my robots/bot 1.xml\"", "clips = [\"builtin:nod\"]", "7 min, whichever ends first", "memory:"]
    {
        assert!(printed.contains(part), "{part}: {printed}");
    }
    assert!(!desk.path("runs").exists(), "nothing was written");
    let value = desk.json(&[&arguments[..], &TINY[..2], &["budget.steps=100000000"]].concat());
    let [total, rate, seconds] = ["total", "per_second", "seconds"].map(|key| value[key].as_f64().unwrap());
    assert!(rate > 0.0 && (seconds - total / rate).abs() < 1e-6 * seconds, "{value}");
}

#[test]
fn a_run_resumes_with_its_own_plan_only() {
    let desk = Desk::new();
    fn train<'a>(more: &[&'a str]) -> Vec<&'a str> {
        [&["train", "tracker", "-o", "run", "--plan", "track"], more].concat()
    }
    desk.out(&train(&TINY));
    let error = desk.refused(&train(&["--resume", "ppo.gamma=0.5"]));
    assert!(error.contains("budget.steps: 192 in the run") && error.contains("leave --plan out"), "{error}");
    desk.out(&train(&[&["--resume"], &TINY[..]].concat()));
    desk.out(&["train", "tracker", "-o", "run", "--resume", "budget.steps=384"]);
}

#[test]
fn outputs_keep_their_kind_and_names_are_guessed() {
    let desk = Desk::new();
    let usage = |arguments: &[&str]| {
        let output = desk.run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    let error = usage(&["generate", "a person waves", "-o", "wave.mp4"]);
    assert!(error.contains("NAME.motion.safetensors"), "{error}");
    assert!(usage(&["eval", "--policy", "lima", "-m", "builtin", "-o", "a.html"]).contains("expected a folder"));
    assert!(!desk.path("wave.mp4").exists());
    let out = desk.out(&["motion", "mirror", "builtin:wave", "-o", "here/left.motion.safetensors"]);
    assert!(desk.path("here/left.motion.safetensors").is_file() && out.contains("demo here/left.motion"), "{out}");
    desk.paste(&proposed(&out)[0]);
    assert!(desk.refused(&["inspect", "limma"]).contains("did you mean 'lima'?"));
    assert!(desk.refused(&["train", "tracker", "--plan", "trakc"]).contains("did you mean 'track'?"));
    assert!(desk.refused(&["motion", "check", "builtin:wavee"]).contains("did you mean 'builtin:wave'?"));
    let error = desk.refused(&["train", "tracker", "--plan", "track", "pppo.gamma=1"]);
    assert!(error.contains("did you mean 'ppo'?"), "{error}");
}

#[test]
fn files_of_another_robot_and_missing_ones_are_refused_in_a_sentence() {
    let desk = Desk::new();
    let error = desk.refused(&["eval", "--policy", "lima", "--robot", "humanoid", "-m", "builtin", "-o", "e"]);
    assert!(error.contains("the policy is for robot 'lima' (20 joints"), "{error}");
    assert!(error.contains("lifelike train tracker --plan track --robot FILE"), "{error}");
    desk.out(&["motion", "mirror", "builtin:wave", "-o", "left.motion.safetensors"]);
    let error = desk.refused(&["motion", "check", "left.motion.safetensors", "--robot", "humanoid"]);
    assert!(error.contains("it is motion of 'lima'; ") && error.contains("--source-robot"), "{error}");
    for missing in ["runs/nothing", "bot.xml"] {
        let error = desk.refused(&["inspect", missing]);
        assert!(error.contains(&format!("{missing}: expected a file or folder, got nothing there")), "{error}");
    }
    for command in [&["retarget", "--robot", "lima"][..], &["convert", "--to", "csv"]] {
        let error = desk.refused(&[&["motion"], command, &["builtin:walk", "-o", "x"]].concat());
        assert!(error.contains("builtin:walk: the program's own clips are not files"), "{error}");
    }
}

#[test]
fn what_was_generated_or_trained_has_a_next_command_and_fits_a_screen() {
    let desk = Desk::new();
    let played = desk.out(&["generate", "a person waves", "--physics", "-o", "waves"]);
    desk.paste(&proposed(&played)[0]);
    assert!(desk.path("runs/explained/report.html").is_file());
    desk.out(&[&["train", "tracker", "--plan", "track", "-o", "run", "clips=builtin:nod"], &TINY[..]].concat());
    let shown = desk.out(&["inspect", "run"]);
    assert!(shown.contains("Train/survival") && !shown.contains("Reward/") && shown.lines().count() < 24, "{shown}");
    let all = desk.out(&["inspect", "run", "--wide"]);
    assert!(all.contains("Reward/height") && all.contains("[ppo]"), "{all}");
}
