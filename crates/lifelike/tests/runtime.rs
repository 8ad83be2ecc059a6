//! A controller on a simulated robot in another process: runs, records, refusals, faults.

#![allow(clippy::unwrap_used, clippy::expect_used)]

#[path = "commands/in_checkout/mod.rs"]
mod in_checkout;

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use in_checkout::{err, json, lifelike, out};
use lifelike_motion::{container, resample::resample};
use lifelike_robot::{Robot as Model, clips};
use lifelike_runtime::record::Record;

/// Short phases, for a test that waits for them in real time, and patience with a machine that does much else.
const SETTINGS: &str = "[durations]\nstand = 0.4\nblend_in = 0.1\nblend_out = 0.1\ndamp = 0.2\n\
    [limits]\nlost_time = 0.6\ndelay_max = 0.6\noverrun_time = 0.6\n";

/// A simulated robot, which ends with the test.
struct Robot {
    child: Child,
    bus: String,
}

impl Robot {
    fn start(words: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lifelike"));
        command.arg("simulate-robot").args(words).args(["--listen", "127.0.0.1:0", "--seconds", "60"]);
        let mut child = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
        let said = lines.find(|line| line.contains("--bus ")).expect("the address");
        let bus = said.split("--bus ").nth(1).unwrap().to_string();
        Self { child, bus }
    }

    /// Runs the policy that needs only a robot's own sensors on it.
    fn run(&self, folder: &Path, words: &[&str]) -> std::process::Output {
        self.run_for("0.5", folder, words)
    }

    /// Runs as [`Self::run`] does, standing for this long (s) twice.
    fn run_for(&self, standing: &str, folder: &Path, words: &[&str]) -> std::process::Output {
        let settings = folder.join("settings.toml");
        std::fs::write(&settings, SETTINGS).unwrap();
        let settings = settings.display().to_string();
        let own = ["run", "lima-blind", "--bus", &self.bus, "--standing", standing, "--settings", &settings];
        lifelike(&[&own[..], words].concat())
    }
}

impl Drop for Robot {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn a_run_over_a_bad_wire_is_recorded_replayed_and_reported() {
    let folder = tempfile::tempdir().unwrap();
    let wire = ["--delay", "3", "--jitter", "3", "--loss", "0.02", "--noise", "0.001", "--gantry", "0.5"];
    let robot = Robot::start(&[&["lima"], &wire[..]].concat());
    let file = folder.path().join("run.mcap").display().to_string();
    let ran = robot.run(folder.path(), &["--json", "--record", &file]);
    assert!(ran.status.success(), "{}", err(&ran));
    let ran: serde_json::Value = serde_json::from_str(&out(&ran)).unwrap();
    let summary = &ran["summary"];
    assert!(summary["steps"].as_u64().unwrap() > 40 && summary["trip"].is_null(), "{summary}");
    assert!(summary["packets"]["reordered"].as_u64().unwrap() + summary["packets"]["lost"].as_u64().unwrap() > 0);
    assert_eq!(summary["unrecorded"], 0);

    let replayed = json(&["replay", &file]);
    assert_eq!((&replayed["difference"], &replayed["ticks"]), (&serde_json::Value::Null, &summary["ticks"]));
    let report = json(&["augment", "report", &file]);
    let joints = report["gaps"].as_array().unwrap().iter().filter(|gap| gap["gap"]["column"] == "position");
    assert_eq!(joints.count(), 20);

    // Another controller sees the same packets, and sends something else.
    let bad = lifelike(&["replay", &file, "--policy", "lima"]);
    assert_eq!(bad.status.code(), Some(1));
    assert!(err(&bad).contains("tick") && err(&bad).contains("recorded"), "{}", err(&bad));
    // Nothing is overwritten.
    let again = robot.run(folder.path(), &["--record", &file]);
    assert!(again.status.code() != Some(0) && err(&again).contains("exists"), "{}", err(&again));
}

/// The robot's engine is MuJoCo, and so is nobody else's: the runtime sees packets.
#[test]
fn a_robot_in_mujoco_stands_and_walks_over_a_bad_wire() {
    let folder = tempfile::tempdir().unwrap();
    let wire = ["--delay", "3", "--jitter", "3", "--loss", "0.02", "--noise", "0.001", "--gantry", "0.5"];
    let robot = Robot::start(&[&["lima", "--engine", "mujoco"], &wire[..]].concat());
    let walk = folder.path().join("walk").display().to_string();
    json(&["motion", "trim", "builtin:walk", "--end", "4", "-o", &walk]);
    let clip = std::fs::read_dir(&walk).unwrap().map(|file| file.unwrap().path());
    let clip = clip.into_iter().find(|path| path.to_string_lossy().ends_with(".motion.safetensors")).unwrap();
    let ran = robot.run_for("1", folder.path(), &["--json", "--motions", clip.to_str().unwrap()]);
    assert!(ran.status.success(), "{}", err(&ran));
    let ran: serde_json::Value = serde_json::from_str(&out(&ran)).unwrap();
    let summary = &ran["summary"];
    // A robot that falls is tilted by more than a radian, or off the reference, and the gate says so.
    assert!(summary["steps"].as_u64().unwrap() > 250 && summary["trip"].is_null(), "{summary}");
    let packets = &summary["packets"];
    assert!(packets["reordered"].as_u64().unwrap() + packets["lost"].as_u64().unwrap() > 0, "{summary}");
}

#[test]
fn faults_end_a_run_with_a_sentence() {
    for (fault, sentence) in [
        ("hot@0.1:left_knee", "the gate braked: joint 'left_knee': motor at 90"),
        ("nan@0.3:left_elbow", "the gate braked: joint 'left_elbow': measurement is no finite number"),
        ("silent@0.3", "the gate braked: no usable packet for 0.6"),
        ("clock@0.3", "the gate braked: the robot's clock jumped ahead by"),
        ("button@0.3", "the gate braked: the robot's stop button"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        // Heat takes its time: 20 degrees a second, from the room's 25.
        let robot = Robot::start(&["lima", "--gantry", "100", "--fault", fault]);
        let long = if fault.starts_with("hot") { "4" } else { "0.5" };
        let ended = robot.run_for(long, folder.path(), &[]);
        assert_eq!(ended.status.code(), Some(1), "{fault}: {}", err(&ended));
        assert!(err(&ended).contains(sentence), "{fault}: {}", err(&ended));
    }
}

#[test]
fn a_robot_that_is_killed_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let mut robot = Robot::start(&["lima"]);
    let bus = robot.bus.clone();
    let killer = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(700));
        robot.child.kill().unwrap();
        robot
    });
    let alone = Robot { child: Command::new("true").spawn().unwrap(), bus };
    let ended = alone.run(folder.path(), &[]);
    drop(killer.join().unwrap());
    assert_eq!(ended.status.code(), Some(1));
    assert!(err(&ended).contains("no usable packet"), "{}", err(&ended));
    // And one that is not there is said to be so.
    let nobody = alone.run(folder.path(), &[]);
    assert_eq!(nobody.status.code(), Some(1));
    assert!(err(&nobody).contains("expected the robot's facts within 3 s"), "{}", err(&nobody));
}

#[test]
fn another_robot_and_dead_motors_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let humanoid = Robot::start(&["humanoid"]);
    let refused = humanoid.run(folder.path(), &[]);
    assert_eq!(refused.status.code(), Some(3));
    let said = err(&refused);
    assert!(said.contains("robot: expected 'lima', got 'humanoid'") && said.contains("joints: expected 20"), "{said}");

    let good = Robot::start(&["lima", "--gantry", "1000"]);
    let tried = good.run(folder.path(), &["--wiggle"]);
    assert!(tried.status.success(), "{}", err(&tried));
    assert!(out(&tried).lines().count() >= 22, "{}", out(&tried));
    let dead = Robot::start(&["lima", "--gantry", "1000", "--fault", "dead@0:left_elbow"]);
    let refused = dead.run(folder.path(), &["--wiggle"]);
    assert_eq!(refused.status.code(), Some(3));
    assert!(err(&refused).contains("motor 'left_elbow': expected its encoder to move"), "{}", err(&refused));
}

#[test]
fn wrong_buses_and_settings_are_refused() {
    let usage = lifelike(&["run", "lima-blind", "--bus", "can0"]);
    assert!(
        usage.status.code() == Some(2) && err(&usage).contains("expected sim:HOST:PORT, replay:FILE, dynamixel:PORT")
    );
    let folder = tempfile::tempdir().unwrap();
    let bad = folder.path().join("bad.toml");
    std::fs::write(&bad, "[limits]\ntorque_share = 2.0\n").unwrap();
    let words = ["run", "lima-blind", "--bus", "sim:127.0.0.1:9", "--settings", bad.to_str().unwrap()];
    let refused = lifelike(&words);
    assert!(refused.status.code() == Some(3) && err(&refused).contains("limits.torque_share"), "{}", err(&refused));
    let none = lifelike(&["replay", "Cargo.toml"]);
    assert!(none.status.code() == Some(3) && err(&none).contains("expected an MCAP record"), "{}", err(&none));
    let printed = out(&lifelike(&["run", "--print-settings"]));
    std::fs::write(&bad, printed).unwrap();
    let unreachable = lifelike(&words);
    assert!(
        err(&unreachable).contains("expected the robot's facts"),
        "the defaults are settings: {}",
        err(&unreachable)
    );
}

/// Copies an example, or makes a scene of a text, in a folder.
fn scene(folder: &Path, name: &str, text: Option<&str>) -> String {
    let path = folder.join(format!("{name}.scene.toml"));
    let text = text.or_else(|| lifelike_studio::examples::find(name).map(|(_, text)| text));
    std::fs::write(&path, text.unwrap()).unwrap();
    path.display().to_string()
}

#[test]
fn scenes_run_on_the_robot_and_replay() {
    let walk = "[[motion]]\nid = \"m1\"\nclip = \"builtin:walk\"\n\n[[push]]\nid = \"p1\"\nat = 1.0\nseconds = 0.2\n\
        body = \"pelvis\"\nnewtons = [0.0, 900.0, 0.0]\n";
    for (name, text, left_out) in [
        ("hello", None, vec![]),
        ("ice", None, vec!["left out, a machine cannot do it: friction (s1, s2)"]),
        ("walk", Some(walk), vec!["left out, a machine cannot do it: pushes (p1)"]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let scene = scene(folder.path(), name, text);
        let played = json(&["play", &scene]);
        let robot = Robot::start(&["lima", "--gantry", "0.5"]);
        let file = folder.path().join("run.mcap").display().to_string();
        let ran = robot.run(folder.path(), &["--json", "--scene", &scene, "--record", &file, "--get-up", "lima"]);
        assert!(ran.status.success(), "{name}: {}", err(&ran));
        for line in &left_out {
            assert!(err(&ran).contains(line), "{name}: {}", err(&ran));
        }
        let ran: serde_json::Value = serde_json::from_str(&out(&ran)).unwrap();
        assert_eq!(ran["left_out"], serde_json::json!(left_out), "{name}");
        let summary = &ran["summary"];
        assert!(summary["trip"].is_null() && summary["falls"] == 0, "{name}: {summary}");
        let blocks = played["blocks"].as_array().unwrap();
        let seconds = blocks.last().unwrap()["to"].as_f64().unwrap();
        assert!(summary["steps"].as_f64().unwrap() > 50.0 * seconds, "{name}: {seconds} s, {summary}");

        // A replay finds the same playlist, and the same commands.
        let replayed = json(&["replay", &file]);
        assert_eq!(replayed["difference"], serde_json::Value::Null, "{name}");
        let record = Record::read(Path::new(&file)).unwrap();
        let attached = record.attached(container::EXTENSION).next().unwrap();
        let clip = container::from_bytes(&attached.bytes, Path::new(name)).unwrap();
        assert_eq!(clip.name, name);
        assert!(clip.seconds() >= seconds, "{name}: {} of {seconds} s", clip.seconds());
        if text.is_some() {
            let model = Model::load("lima").unwrap();
            let walk = clips::load_one(Path::new("builtin:walk"), &model).unwrap();
            let walk = resample(&walk, model.control_hz).unwrap();
            let first = 50 * walk.joint_names.len();
            assert_eq!(clip.joints[..first], walk.joints[..first], "a block is its clip");
        }
    }
}

#[test]
fn scenes_that_no_robot_can_follow_are_refused_with_their_line() {
    let folder = tempfile::tempdir().unwrap();
    let block = |what: &str| format!("robot = \"lima\"\n[[motion]]\nid = \"m1\"\n{what}\n");
    for (text, line, sentence) in [
        ("# another\nrobot = \"humanoid\"\n".to_string(), 2, "robot: expected that of the controller, 'lima'"),
        ("robot = \"nobody\"\n".to_string(), 1, "robot: expected that of the controller, 'lima'"),
        (block("sentence = \"a person flies to the moon\""), 3, "block 'm1': cannot do"),
        (block("clip = \"builtin:kick\"\nspeed = 5"), 3, "block 'm1': not feasible: "),
        (block("clip = \"../secret.bvh\""), 3, "block 'm1'"),
        (block("clips = \"builtin:kick\""), 4, "unknown field `clips`"),
    ] {
        let file = scene(folder.path(), "bad", Some(&text));
        let refused = lifelike(&["run", "lima-blind", "--bus", "sim:127.0.0.1:9", "--scene", &file]);
        assert_eq!(refused.status.code(), Some(3), "{text}: {}", err(&refused));
        let said = err(&refused);
        assert!(said.contains(&format!("{file}:{line}: {sentence}")), "{text}: {said}");
    }
    let file = scene(folder.path(), "hello", None);
    let both = ["run", "lima-blind", "--bus", "sim:127.0.0.1:9", "--scene", &file, "--motions", "builtin:walk"];
    assert_eq!(lifelike(&both).status.code(), Some(2));
}
