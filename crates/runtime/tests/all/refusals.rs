//! A drill: a mismatch of each kind, and the sentence that refuses it.
use crate::common;
use crate::common::{Fault, Plant};
use lifelike_robot::{Controller, ControllerFile};
use lifelike_runtime::wiggle::{defects, identify};
use lifelike_runtime::{Config, Facts, Limits, VirtualClock, handshake};

/// Makes one mismatch.
type Change = fn(&mut Facts);

fn refusal(change: impl FnOnce(&mut Facts)) -> String {
    let controller = common::controller();
    let mut facts = Facts::of(controller.robot(), 1000.0, 1000.0);
    change(&mut facts);
    let error = handshake::check(&controller, &facts, &Config::default()).unwrap_err().to_string();
    println!("{error}");
    error
}

#[test]
fn the_robot_of_the_controller_is_accepted() {
    let controller = common::controller();
    let facts = Facts::of(controller.robot(), 1000.0, 1000.0);
    assert_eq!(handshake::differences(&controller, &facts, &Config::default()), [""; 0]);
    // A machine may not know its digest.
    let facts = Facts { digest: String::new(), ..facts };
    handshake::check(&controller, &facts, &Config::default()).unwrap();
}

#[test]
fn every_mismatch_is_refused_by_name() {
    let cases: [(&str, Change); 13] = [
        ("robot: expected 'lima', got 'humanoid'", |facts| facts.robot = "humanoid".into()),
        ("joints: expected 20, got 19", |facts| facts.joints.truncate(19)),
        ("joint 1: expected 'left_hip_yaw', got 'left_hip_roll': same joints, another order", |facts| {
            facts.joints.swap(0, 1);
        }),
        ("joint 4: expected 'left_knee', got 'knee'", |facts| facts.joints[3] = "knee".into()),
        ("motors: expected 20, got 18: a motor does not answer", |facts| facts.motors = 18),
        ("control mode: expected 'position', got 'sport'", |facts| facts.mode = "sport".into()),
        ("digest of the robot's description: expected 5a9e74c127df, got 000000000000", |facts| {
            facts.digest = "0".repeat(64);
        }),
        ("commands: expected 1000 Hz, got at most 500 Hz", |facts| facts.command_hz_max = 500.0),
        ("measurements: expected at least 50 Hz, got 25 Hz", |facts| facts.state_hz = 25.0),
        ("kp of joint 'left_knee': expected 15, got 20", |facts| facts.kp[3] = 20.0),
        ("largest torque of joint 'left_knee': expected 34, got NaN", |facts| facts.torque_max[3] = f64::NAN),
        ("range of joint 'left_knee': expected 0.000 to 2.400 rad, got -1.000 to 2.400 rad", |facts| {
            facts.range[3] = Some((-1.0, facts.range[3].unwrap().1));
        }),
        ("IMU: expected the orientation of the root, got turned by 180.0 degrees", |facts| {
            facts.imu_orientation = [0.0, 0.0, 0.0, 1.0];
        }),
    ];
    for (expected, change) in cases {
        let text = refusal(change);
        assert!(text.contains(expected), "expected '{expected}' in '{text}'");
    }
}

#[test]
fn two_mismatches_are_two_lines() {
    let text = refusal(|facts| {
        facts.kd[0] = 9.0;
        facts.motors = 19;
    });
    assert_eq!(text.lines().count(), 3, "{text}");
}

#[test]
fn a_controller_whose_golden_vectors_differ_is_refused() {
    let path = common::asset("lima-blind.controller.safetensors");
    let mut bytes = std::fs::read(&path).unwrap();
    // The lowest byte of the exponent of a weight in the middle of the file.
    let middle = bytes.len() / 2 / 4 * 4 + 3;
    bytes[middle] ^= 0x02;
    let folder = tempfile::tempdir().unwrap();
    let damaged = folder.path().join("x.controller.safetensors");
    std::fs::write(&damaged, bytes).unwrap();
    let error = ControllerFile::read(&damaged).unwrap_err().to_string();
    println!("{error}");
    assert!(error.contains("x.controller.safetensors"), "{error}");
    let g1 = Controller::load(&common::asset("g1-deploy.controller.safetensors"), common::lima());
    let error = g1.unwrap_err().to_string();
    println!("{error}");
    assert!(error.contains("joints"), "{error}");
}

fn wiggled(fault: Fault) -> Vec<String> {
    let mut plant = Plant::new(2);
    plant.fault = fault;
    let joints = plant.robot.layout.joints.clone();
    let config = Config::default();
    let limits = Limits::of(&plant.robot, config.limits).unwrap();
    let (responses, trip) = identify(&joints, limits, 1000.0, &mut plant, &mut VirtualClock::default());
    let lines = defects(&responses, &joints);
    println!("{fault:?}: {lines:?} {trip:?}");
    lines
}

#[test]
fn a_wiggle_finds_dead_and_swapped_encoders() {
    assert_eq!(wiggled(Fault::None), [""; 0]);
    let dead = wiggled(Fault::Dead(3));
    assert_eq!(dead.len(), 1, "{dead:?}");
    assert!(dead[0].starts_with("motor 'left_knee': expected its encoder to move, got") && dead[0].ends_with("dead"));
    let swapped = wiggled(Fault::Swapped(3, 8));
    assert_eq!(
        swapped,
        [
            "motor 'left_knee': expected its own encoder to move, got that of 'right_knee': swapped",
            "motor 'right_knee': expected its own encoder to move, got that of 'left_knee': swapped",
        ]
    );
}
