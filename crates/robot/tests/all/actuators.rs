//! The drive of every joint is what MuJoCo compiles, and everything that it does not say is said to be invented.
//!
//! The models of `actuators/` are ours; `compiled.json` beside them is MuJoCo 4.0's, by `peers/robots/compiled.py`.
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use lifelike_robot::{Robot, Severity, Shapes};

#[derive(Debug, serde::Deserialize)]
struct Compiled {
    range: Option<(f64, f64)>,
    drive: Option<Drive>,
}

#[derive(Debug, serde::Deserialize)]
struct Drive {
    stiffness: f64,
    damping: f64,
    torque: Option<(f64, f64)>,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/actuators")
}

fn load(name: &str) -> Robot {
    Robot::load(&folder().join(format!("{name}.xml")).to_string_lossy()).unwrap()
}

/// Gains, torque and speed of a joint.
fn actuator(robot: &Robot, joint: &str) -> (f64, f64, f64) {
    let index = robot.actuators.joints.iter().position(|name| name == joint).unwrap();
    let p = robot.actuators.parameters[index];
    (p.kp, p.kd, p.torque_max)
}

/// The line of `inspect` about a joint's actuator.
fn note(robot: &Robot, joint: &str) -> String {
    let start = format!("actuator of '{joint}'");
    robot.notes.iter().find(|note| note.starts_with(&start)).unwrap_or_else(|| panic!("{:?}", robot.notes)).clone()
}

#[track_caller]
fn warns(robot: &Robot, words: &[&str]) {
    let has = |text: &String| words.iter().all(|word| text.contains(word));
    assert!(robot.character.warnings.iter().any(has), "{words:?} in {:?}", robot.character.warnings);
}

/// Numbers are computed in f64 from the same ones.
fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * b.abs().max(1.0)
}

#[test]
fn every_drive_is_mujocos() {
    let text = std::fs::read_to_string(folder().join("compiled.json")).unwrap();
    let files: BTreeMap<String, BTreeMap<String, Compiled>> = serde_json::from_str(&text).unwrap();
    assert!(files.len() >= 23, "{}", files.len());
    for (file, joints) in files {
        let robot = load(file.trim_end_matches(".xml"));
        assert_eq!(robot.actuators.joints.len(), joints.len(), "{file}");
        for (name, compiled) in joints {
            let index = robot.character.joint(&name).unwrap();
            let pair = |a: Option<(f64, f64)>, b: Option<(f64, f64)>| match (a, b) {
                (None, None) => true,
                (Some(a), Some(b)) => close(a.0, b.0) && close(a.1, b.1),
                _ => false,
            };
            let range = robot.character.joints[index].range;
            assert!(pair(range, compiled.range), "{file} {name}: {range:?} for {:?}", compiled.range);
            let ours = robot.character.drive(index);
            let (Some(ours), Some(theirs)) = (ours, &compiled.drive) else {
                assert!(ours.is_none() && compiled.drive.is_none(), "{file} {name}: {ours:?} for {compiled:?}");
                continue;
            };
            let same = close(ours.stiffness, theirs.stiffness) && close(ours.damping, theirs.damping);
            assert!(same && pair(ours.torque, theirs.torque), "{file} {name}: {ours:?} for {theirs:?}");
            let (kp, kd, torque) = actuator(&robot, &name);
            if theirs.stiffness > 0.0 {
                assert!(close(kp, theirs.stiffness) && close(kd, theirs.damping), "{file} {name}: kp {kp} kd {kd}");
                assert!(note(&robot, &name).contains("the model's gains"), "{}", note(&robot, &name));
            } else {
                assert!(
                    note(&robot, &name).contains("kp invented") || note(&robot, &name).contains("kp and kd invented")
                );
            }
            match theirs.torque {
                Some((low, high)) => assert!(close(torque, high.min(-low)), "{file} {name}: {torque}"),
                None => assert!(note(&robot, &name).contains("torque invented from the weight"), "{file} {name}"),
            }
        }
    }
}

#[test]
fn a_servo_without_damping_gets_none() {
    // The joint's own 1.5 N m s/rad stay with the joint.
    let damped = load("no_kv");
    assert_eq!(actuator(&damped, "hip").1, 0.0);
    assert_eq!(damped.character.joints[damped.character.joint("hip").unwrap()].damping, 1.5);
    assert!(note(&damped, "hip").contains("kp 60.000, kd 0.000") && !note(&damped, "hip").contains("kd invented"));
    warns(&damped, &["without any damping", "knee"]);
    assert!(damped.character.warnings.iter().all(|w| !(w.contains("without any damping") && w.contains("hip"))));
}

#[test]
fn what_moves_nothing_is_no_motor() {
    for name in ["unactuated", "damper_alone"] {
        let robot = load(name);
        assert_eq!(actuator(&robot, "knee"), (0.0, 0.0, 0.0), "{name}");
        warns(&robot, &["joints without an actuator", "knee"]);
        assert!(note(&robot, "knee").contains("the model has no actuator for it"));
    }
}

#[test]
fn a_servo_without_stiffness_is_a_damper() {
    // MuJoCo compiles gain 0 and bias 0 0 -3.
    let text = std::fs::read_to_string(folder().join("damper_alone.xml")).unwrap();
    let damper = "<damper joint=\"knee\" kv=\"3\" ctrlrange=\"0 10\"/>";
    assert!(text.contains(damper));
    for servo in [
        "<position joint=\"knee\" kp=\"0\" kv=\"3\" forcerange=\"-20 20\"/>",
        "<general joint=\"knee\" gainprm=\"0\" biastype=\"affine\" biasprm=\"0 0 -3\" forcerange=\"-20 20\"/>",
    ] {
        let text = text.replace(damper, servo);
        let character = lifelike_character::Character::from_mjcf(&text, "x.xml", None).unwrap();
        let robot = Robot::from_character(character, lifelike_robot::Profile::default()).unwrap();
        assert_eq!(actuator(&robot, "knee"), (0.0, 3.0, 20.0), "{servo}");
        assert!(note(&robot, "knee").contains("the model's damper; the model's limit"), "{}", note(&robot, "knee"));
        assert!(robot.notes.iter().all(|note| !note.contains("rotor of 'knee'")), "{:?}", robot.notes);
        assert!(robot.character.warnings.iter().all(|w| !w.contains("swing freely")), "{:?}", robot.character.warnings);
    }
}

#[test]
fn controls_that_are_angles_or_velocities_limit_no_torque() {
    for name in ["velocity", "intvelocity", "gear", "no_kp"] {
        let note = note(&load(name), "hip");
        assert!(note.contains("torque invented from the weight"), "{name}: {note}");
    }
    assert_eq!(actuator(&load("velocity"), "hip").1, 5.0);
    assert!(note(&load("velocity"), "hip").contains("the model's kd, kp invented"));
}

#[test]
fn unequal_directions_get_the_smaller_one_and_say_so() {
    let robot = load("asymmetric");
    assert_eq!((actuator(&robot, "hip").2, actuator(&robot, "knee").2), (20.0, 30.0));
    warns(&robot, &["differ by direction", "hip (-20 to 60 N m)", "knee (-70 to 30 N m)"]);
}

#[test]
fn gains_that_hold_nothing_are_no_robot() {
    // 0.5 N m/rad over 3 rad for a biped of 9 kg.
    let text = std::fs::read_to_string(folder().join("no_kp.xml")).unwrap();
    let legs = text.replace("\"thigh\"", "\"left_thigh\"").replace("\"shank\"", "\"left_shank\"");
    let legs = legs.replace("mass=\"1.2\"/>", "mass=\"1.2\"/><body name=\"left_foot\" pos=\"0 0 -.35\"><joint name=\"ankle\" axis=\"0 1 0\" range=\"-1 1\"/><geom size=\".03\" mass=\".3\"/></body>");
    let robot = |text: &str| {
        let character = lifelike_character::Character::from_mjcf(text, "x.xml", None).unwrap();
        Robot::from_character(character, lifelike_robot::Profile::default()).unwrap()
    };
    let soft = robot(&legs.replace("<position ", "<position kp=\".5\" ")).readiness(Shapes::Primitives);
    assert!(!soft.can_train() && soft.verdict().contains("gains of its legs are too soft"), "{soft:?}");
    let stiff = robot(&legs.replace("<position ", "<position kp=\"90\" kv=\"3\" ")).readiness(Shapes::Primitives);
    assert!(stiff.problems.iter().all(|p| p.severity == Severity::Warning), "{stiff:?}");
}

#[test]
fn forces_that_are_no_motors_are_refused_with_a_word() {
    let text = std::fs::read_to_string(folder().join("unactuated.xml")).unwrap();
    let with = |actuator: &str| {
        let text = text.replace("<motor joint=\"hip\" gear=\"60\" ctrlrange=\"-1 1\"/>", actuator);
        lifelike_character::Character::from_mjcf(&text, "x.xml", None).unwrap_err().to_string()
    };
    let muscle = with("<muscle joint=\"hip\" ctrlrange=\"0 1\"/>");
    assert!(muscle.starts_with("x.xml:19: <muscle>: unsupported kind of actuator 'muscle'"), "{muscle}");
    assert!(muscle.contains("use <motor>, <position> or <general>"), "{muscle}");
    assert!(with("<plugin joint=\"hip\" plugin=\"mujoco.pid\"/>").contains("'plugin'"));
    assert!(
        with("<position joint=\"hip\" kv=\"1\" dampratio=\"1\"/>").contains("expected 'kv' or 'dampratio', got both")
    );
    assert!(with("<position joint=\"hip\" kv=\"-1\"/>").contains("'kv' that is not negative"));
    assert!(with("<general joint=\"hip\" gaintype=\"user\"/>").contains("gaintype 'user'"));
    assert!(
        with("<general joint=\"hip\" gaintype=\"affine\" gainprm=\"1 2\"/>")
            .contains("depends on the joint's position")
    );
}
