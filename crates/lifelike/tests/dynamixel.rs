//! A controller on a robot of Dynamixel servos: physics behind control tables on a pseudo terminal, from packets to a stand.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, clippy::expect_used)]

#[path = "commands/in_checkout/mod.rs"]
mod in_checkout;
mod servos;

use std::path::Path;
use std::process::Output;

use in_checkout::{err, json, lifelike, out};
use lifelike_robot::Robot;
use servos::{Account, Fault, Faults, Servos};

/// Short phases, and patience with a machine that does much else.
const SETTINGS: &str = "command_hz = 400.0\n[durations]\nstand = 0.4\nblend_in = 0.1\nblend_out = 0.1\ndamp = 0.3\n\
    [limits]\nlost_time = 0.6\ndelay_max = 0.6\noverrun_time = 0.6\nbattery_min = 10.0\n";
/// Places of joints in lima.
const KNEE: usize = 3;

/// Runs the policy that needs only a robot's own sensors on servos, standing for this long (s) twice.
fn run(folder: &Path, servos: &Servos, standing: &str, words: &[&str]) -> Output {
    let file = folder.join("servos.toml");
    if !file.exists() {
        std::fs::write(&file, servos::file(&Robot::load("lima").unwrap())).unwrap();
    }
    let settings = folder.join("settings.toml");
    std::fs::write(&settings, SETTINGS).unwrap();
    let bus = format!("dynamixel:{},servos={},imu={}", servos.port, file.display(), servos.imu);
    let settings = settings.display().to_string();
    let own = ["run", "lima-blind", "--bus", &bus, "--standing", standing, "--settings", &settings];
    lifelike(&[&own[..], words].concat())
}

/// Runs on servos with faults; returns the exit code, the sentence and the robot's account.
fn faulty(faults: Faults, standing: &str) -> (Option<i32>, String, Account) {
    let folder = tempfile::tempdir().unwrap();
    let robot = Servos::start(faults, 100.0);
    let ended = run(folder.path(), &robot, standing, &[]);
    (ended.status.code(), err(&ended), robot.end())
}

#[test]
fn a_robot_of_servos_stands_under_a_policy_and_its_record_replays() {
    assert_eq!(Robot::load("lima").unwrap().layout.joints[KNEE], "left_knee");
    let folder = tempfile::tempdir().unwrap();
    let robot = Servos::start(Vec::new(), 0.6);
    let file = folder.path().join("servos.mcap").display().to_string();
    let ran = run(folder.path(), &robot, "1.0", &["--json", "--record", &file]);
    let account = robot.end();
    assert!(ran.status.success(), "{} {} {account:?}", err(&ran), out(&ran));
    let ran: serde_json::Value = serde_json::from_str(&out(&ran)).unwrap();
    let summary = &ran["summary"];
    assert!(summary["steps"].as_u64().unwrap() > 80 && summary["trip"].is_null(), "{summary}");
    // Let go 0.6 s after motors were on, it stands on its own feet for more than a second, until motors brake.
    assert!((0.3..2.0).contains(&account.lowest), "{account:?}");
    assert_eq!((account.enabled, account.watched), (0, 20), "torque is off at the end; watchdogs watched: {account:?}");
    assert!(account.goals > 100, "{account:?}");
    let replayed = json(&["replay", &file]);
    assert_eq!((&replayed["difference"], &replayed["ticks"]), (&serde_json::Value::Null, &summary["ticks"]));
}

#[test]
fn faults_of_one_servo_end_a_run_with_a_sentence() {
    let no_number = "the gate braked: joint 'left_knee': measurement is no finite number";
    for (fault, sentences) in [
        (Fault::Silent(KNEE), &[no_number][..]),
        (Fault::Checksum(KNEE), &[no_number]),
        (
            Fault::Hardware(KNEE, 0b10_0100),
            &[no_number, "servo 4 (joint 'left_knee'): hardware error: overheating, overload"],
        ),
        (Fault::Hot(KNEE, 95), &["the gate braked: joint 'left_knee': motor at 95"]),
        (Fault::Voltage(9.5), &["the gate braked: battery at 9.5"]),
        (Fault::NoImu, &["the gate braked: no usable packet for 0.6"]),
    ] {
        let (code, said, account) = faulty(vec![(0.8, fault)], "1.5");
        assert_eq!(code, Some(1), "{fault:?}: {said} {account:?}");
        sentences.iter().for_each(|sentence| assert!(said.contains(sentence), "{fault:?}: {said}"));
        assert_eq!(account.enabled, 0, "{fault:?}: torque is off at the end");
    }
}

#[test]
fn servos_that_are_not_those_of_the_file_are_refused_before_they_move() {
    let knee = "servo 4 (joint 'left_knee'): expected ";
    let elbow = Robot::load("lima").unwrap().layout.joints.iter().position(|joint| joint == "left_elbow").unwrap();
    for (fault, part) in [
        (Fault::Silent(KNEE), format!("{knee}an answer at 4000000 bits/s, got none")),
        (Fault::Checksum(KNEE), format!("{knee}an answer at 4000000 bits/s, got none")),
        (Fault::Model(KNEE, 1060), format!("{knee}XH540-W150 (1110), got XL430-W250 (1060)")),
        (Fault::Swapped(KNEE, elbow), format!("{knee}XH540-W150 (1110), got XM430-W350 (1020): are ids exchanged?")),
        (Fault::Hardware(KNEE, 1), format!("{knee}no hardware error, got input voltage")),
        (Fault::Reversed(KNEE), format!("{knee}its joint at ")),
    ] {
        let (code, said, account) = faulty(vec![(0.0, fault)], "0.5");
        assert_eq!(code, Some(3), "{fault:?}: {said}");
        assert!(said.contains(&part), "{fault:?}: {said}");
        assert_eq!((account.goals, account.enabled), (0, 0), "{fault:?}");
    }
}

#[test]
fn a_run_without_an_imu_or_with_a_wrong_file_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let robot = Servos::start(vec![(0.0, Fault::NoImu)], 100.0);
    let ended = run(folder.path(), &robot, "0.5", &[]);
    assert_eq!(ended.status.code(), Some(1));
    assert!(err(&ended).contains("expected a packet of the IMU on 127.0.0.1:"), "{}", err(&ended));
    let file = folder.path().join("servos.toml");
    let bus = |options: &str| format!("dynamixel:{},servos={}{options}", robot.port, file.display());
    let said = |bus: &str, code: i32| {
        let ended = lifelike(&["run", "lima-blind", "--bus", bus]);
        assert_eq!(ended.status.code(), Some(code), "{}", err(&ended));
        err(&ended)
    };
    assert!(said(&bus(""), 1).contains("expected imu=HOST:PORT: the gate compares the root's tilt"));
    let none = format!("dynamixel:/dev/none,servos={},imu={}", file.display(), robot.imu);
    assert!(said(&none, 1).contains("expected a packet of the IMU"), "the IMU is asked first");
    assert!(said(&bus(",speed=3"), 2).contains("dynamixel:PORT[,servos=FILE][,imu=HOST:PORT]"));
    let good = std::fs::read_to_string(&file).unwrap();
    for (from, to, part) in [
        ("joint = 'left_knee'", "joint = 'tail'", "servo 4: expected a joint of 'lima', got 'tail'"),
        ("id = 4\n", "id = 3\n", "id: expected id of one servo only"),
        ("p_gain", "gain", "servos.toml:"),
    ] {
        std::fs::write(&file, good.replacen(from, to, 1)).unwrap();
        let words = said(&bus(",imu=127.0.0.1:0"), 3);
        assert!(words.contains(part), "{words}");
    }
}
