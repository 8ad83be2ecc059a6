//! Refusal before the first command: a line for everything in which the machine differs from the controller's robot.

use lifelike_robot::Controller;

use crate::bus::Facts;
use crate::config::Config;
use crate::error::RuntimeError;

/// Largest difference of gains and torques, as a share.
const SHARE: f64 = 1e-3;
/// Largest difference of ranges (rad), and of the IMU's orientation (rad).
const ANGLE: f64 = 0.01;

/// Returns a line for each difference between the machine and the controller's robot.
pub fn differences(controller: &Controller, facts: &Facts, config: &Config) -> Vec<String> {
    let robot = controller.robot();
    let (joints, parameters) = (&robot.layout.joints, &robot.actuators.parameters);
    let mut lines = Vec::new();
    let mut differs = |what: &str, expected: String, got: String, remedy: &str| {
        lines.push(format!("{what}: expected {expected}, got {got}{remedy}"));
    };
    if facts.robot != robot.name {
        differs("robot", format!("'{}'", robot.name), format!("'{}'", facts.robot), "");
    }
    if facts.joints.len() != joints.len() {
        differs("joints", joints.len().to_string(), facts.joints.len().to_string(), "");
        return lines;
    }
    if let Some(i) = (0..joints.len()).find(|&i| joints[i] != facts.joints[i]) {
        let same_names = joints.iter().all(|joint| facts.joints.contains(joint));
        let remedy = if same_names { ": same joints, another order" } else { "" };
        differs(&format!("joint {}", i + 1), format!("'{}'", joints[i]), format!("'{}'", facts.joints[i]), remedy);
        return lines;
    }
    if facts.motors != joints.len() {
        let remedy = ": a motor does not answer";
        differs("motors", joints.len().to_string(), facts.motors.to_string(), remedy);
    }
    if facts.mode != "position" {
        differs("control mode", "'position'".into(), format!("'{}'", facts.mode), ": switch the robot's mode");
    }
    let own = lifelike_robot::controller::RobotDescription::of(robot).digest;
    if !facts.digest.is_empty() && facts.digest != own {
        let short = |digest: &str| digest.chars().take(12).collect::<String>();
        differs("digest of the robot's description", short(&own), short(&facts.digest), "");
    }
    if facts.command_hz_max < config.command_hz {
        let got = format!("at most {} Hz", facts.command_hz_max);
        differs("commands", format!("{} Hz", config.command_hz), got, ": set command_hz in the settings");
    }
    if facts.state_hz < robot.control_hz {
        differs("measurements", format!("at least {} Hz", robot.control_hz), format!("{} Hz", facts.state_hz), "");
    }
    for (j, joint) in joints.iter().enumerate() {
        let numbers = [
            ("kp", parameters[j].kp, facts.kp.get(j), SHARE * parameters[j].kp),
            ("kd", parameters[j].kd, facts.kd.get(j), SHARE * parameters[j].kd),
            ("largest torque", parameters[j].torque_max, facts.torque_max.get(j), SHARE * parameters[j].torque_max),
        ];
        for (what, expected, got, tolerance) in numbers {
            // NaN and none are differences.
            if !got.is_some_and(|got| (got - expected).abs() <= tolerance) {
                let got = got.map_or("none".into(), f64::to_string);
                differs(&format!("{what} of joint '{joint}'"), expected.to_string(), got, "");
            }
        }
    }
    for (joint, got) in robot.character.scalar_joints().zip(&facts.range) {
        let same = match (joint.range, got) {
            (None, _) => true,
            (Some(_), None) => false,
            // The machine may have less than the model, never more of it than that.
            (Some((low, high)), Some((least, most))) => (least - low).abs() <= ANGLE && (most - high).abs() <= ANGLE,
        };
        if !same {
            let say = |range: Option<(f64, f64)>| range.map_or("none".into(), |(a, b)| format!("{a:.3} to {b:.3} rad"));
            differs(&format!("range of joint '{}'", joint.name), say(joint.range), say(*got), "");
        }
    }
    let [w, x, y, z] = facts.imu_orientation;
    let turned = 2.0 * (x * x + y * y + z * z).sqrt().atan2(w.abs());
    if turned.is_nan() || turned > ANGLE {
        let got = format!("turned by {:.1} degrees", turned.to_degrees());
        differs("IMU", "the orientation of the root".into(), got, ": turn its readings before they are sent");
    }
    lines
}

/// Checks that a machine is the one of the controller.
///
/// # Errors
/// [`RuntimeError::Refused`] with all [`differences`].
pub fn check(controller: &Controller, facts: &Facts, config: &Config) -> Result<(), RuntimeError> {
    let lines = differences(controller, facts, config);
    if lines.is_empty() { Ok(()) } else { Err(RuntimeError::Refused(lines.join("\n  "))) }
}
