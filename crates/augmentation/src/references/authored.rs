//! Motions that a person wrote for a robot that is fixed to the world: poses at times.
//!
//! ```toml
//! about = "kicks, and swings the arms"
//! seconds = 4.0                            # the poses repeat after this
//!
//! [[pose]]
//! time = 0.0
//! joints = { left_knee = 35, neck_yaw = 10 }               # degrees beside the default pose
//! bodies.trunk = { z = -0.02, yaw = 15 }                   # m and degrees beside the default pose: x, y, z, roll, pitch, yaw
//! ```
//! A joint that a pose does not name goes on its way between the poses that do. Between poses runs a quintic curve
//! without overshoot. Bodies are brought to their places by inverse kinematics; what closes a loop through the ground
//! stays where it is.

use std::collections::BTreeMap;
use std::path::Path;

use lifelike_character::rotation::{Quat, Vec3};
use lifelike_motion::keyframes::curve::Curve;
use lifelike_robot::Robot;
use lifelike_sim::trace::Trace;

use super::inverse::{Goal, Inverse};
use super::{FIRST, TURN, commands, held};
use crate::{AugmentationError, FromInput};

/// Ending of the files' names.
pub const EXTENSION: &str = ".poses.toml";
/// Joints that bodies need not turn stay near what the poses say, with this weight (m/rad).
const WISH: f64 = 0.003;
/// Steps of the inverse kinematics for a row.
const STEPS: usize = 6;

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Script {
    #[serde(default)]
    about: String,
    seconds: f64,
    pose: Vec<Pose>,
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Pose {
    time: f64,
    #[serde(default)]
    joints: BTreeMap<String, f64>,
    #[serde(default)]
    bodies: BTreeMap<String, BTreeMap<String, f64>>,
}

/// Coordinates of a body beside its default place.
const COORDINATES: [&str; 6] = ["x", "y", "z", "roll", "pitch", "yaw"];

/// Reads a motion and plays it `speed` times as fast for some seconds, over and over.
///
/// # Errors
/// The file, and what in it is not as it should be: times out of order, joints and bodies that the robot has not.
pub fn load(path: &Path, robot: &Robot, seconds: f64, speed: f64) -> Result<Trace, AugmentationError> {
    let text = std::fs::read_to_string(path).map_err(AugmentationError::io(path))?;
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let name = name.strip_suffix(EXTENSION).unwrap_or(&name).to_string();
    parse(&text, path, &name, robot, seconds, speed)
}

/// Returns an error about a place of the file.
fn wrong(path: &Path, place: impl Into<String>, expected: impl ToString, got: impl ToString) -> AugmentationError {
    let (expected, got) = (expected.to_string(), got.to_string());
    AugmentationError::Log { path: path.to_path_buf(), place: place.into(), expected, got }
}

fn parse(
    text: &str,
    path: &Path,
    name: &str,
    robot: &Robot,
    seconds: f64,
    speed: f64,
) -> Result<Trace, AugmentationError> {
    let script: Script =
        toml::from_str(text).map_err(|error| wrong(path, "TOML", "poses at times", error.to_string().trim()))?;
    check(&script, path, robot)?;
    let curve = |keys: Vec<(f64, f64)>| (!keys.is_empty()).then(|| Curve::new(&keys, Some(script.seconds)));
    let of_joint = |name: &String| {
        curve(script.pose.iter().filter_map(|pose| Some((pose.time, pose.joints.get(name)?.to_radians()))).collect())
    };
    let joints: Vec<Option<Curve>> = robot.layout.joints.iter().map(of_joint).collect();
    let names: std::collections::BTreeSet<&String> = script.pose.iter().flat_map(|pose| pose.bodies.keys()).collect();
    let coordinate = |name: &String, which: &str| {
        let value = |pose: &Pose| Some((pose.time, *pose.bodies.get(name)?.get(which)?));
        curve(script.pose.iter().filter_map(value).collect())
    };
    let bodies = names.into_iter().map(|name| {
        let body = robot.character.body(name).map_err(|error| wrong(path, "bodies", "a body of the robot", error))?;
        Ok((body, COORDINATES.map(|which| coordinate(name, which))))
    });
    let bodies = bodies.collect::<Result<Vec<_>, AugmentationError>>()?;
    let held = held(robot)?;
    let mut inverse = Inverse::new(&robot.character, &robot.default_pose);
    let default = inverse.kinematics().clone();
    let mut rows = Vec::new();
    for row in 0..(seconds * robot.control_hz).round() as usize {
        let time = row as f64 / robot.control_hz * speed;
        let at = |curve: &Option<Curve>| curve.as_ref().map_or(0.0, |curve| curve.at(time));
        let wish: Vec<f64> = robot.default_pose.iter().zip(&joints).map(|(rest, curve)| rest + at(curve)).collect();
        if held.is_empty() && bodies.is_empty() {
            let limits = robot.character.scalar_joints().map(|joint| joint.range);
            let clamp = |(q, range): (f64, Option<(f64, f64)>)| range.map_or(q, |(low, high)| q.clamp(low, high));
            rows.push(wish.into_iter().zip(limits).map(clamp).collect());
            continue;
        }
        let mut goals = held.clone();
        for (body, curves) in &bodies {
            let [x, y, z, roll, pitch, yaw] = std::array::from_fn(|i| at(&curves[i]));
            let target = default.body_position[*body] + Vec3::new(x, y, z);
            goals.push(Goal::Place { body: *body, point: Vec3::zeros(), target, weight: 1.0 });
            let turn = Quat::from_euler_angles(roll.to_radians(), pitch.to_radians(), yaw.to_radians());
            goals.push(Goal::Turn { body: *body, target: turn * default.body_orientation[*body], weight: TURN });
        }
        inverse.solve(&goals, &wish, WISH, if row == 0 { FIRST } else { STEPS });
        rows.push(inverse.pose());
    }
    Ok(commands(name, format!("authored: {}", script.about), robot, &rows))
}

fn check(script: &Script, path: &Path, robot: &Robot) -> Result<(), AugmentationError> {
    if !(script.seconds.is_finite() && script.seconds > 0.0) {
        return Err(wrong(path, "seconds", "a number above 0", script.seconds));
    }
    if script.pose.is_empty() {
        return Err(wrong(path, "pose", "one or more", "none"));
    }
    let mut before = -f64::MIN_POSITIVE;
    for (i, pose) in script.pose.iter().enumerate() {
        let place = format!("pose {}", i + 1);
        if !(pose.time > before && pose.time < script.seconds) {
            let expected = format!("a time above the pose's before and below {} s", script.seconds);
            return Err(wrong(path, place, expected, pose.time));
        }
        before = pose.time;
        if let Some(name) = pose.joints.keys().find(|name| !robot.layout.joints.contains(name)) {
            return Err(wrong(path, place, format!("joints of '{}': {:?}", robot.name, robot.layout.joints), name));
        }
        for (body, numbers) in &pose.bodies {
            if let Some(name) = numbers.keys().find(|name| !COORDINATES.contains(&name.as_str())) {
                return Err(wrong(path, format!("{place}, body '{body}'"), format!("{COORDINATES:?}"), name));
            }
        }
        let numbers = pose.joints.values().chain(pose.bodies.values().flat_map(BTreeMap::values));
        if let Some(x) = numbers.into_iter().find(|x| !x.is_finite()) {
            return Err(wrong(path, place, "finite numbers", x));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn robot(name: &str) -> Robot {
        Robot::load(&format!("{}/../robot/robots/{name}.xml", env!("CARGO_MANIFEST_DIR"))).unwrap()
    }

    fn read(text: &str, robot: &Robot, speed: f64) -> Result<Trace, AugmentationError> {
        parse(text, Path::new("nod.poses.toml"), "nod", robot, 4.0, speed)
    }

    const NOD: &str = "seconds = 2.0\n[[pose]]\ntime = 0.0\njoints = { neck_yaw = 0 }\n[[pose]]\ntime = 1.0\njoints = { neck_yaw = 30 }\n";

    #[test]
    fn joints_go_through_the_poses_and_repeat() {
        let robot = robot("kickbot");
        let neck = robot.layout.joints.iter().position(|name| name == "neck_yaw").unwrap();
        let at = |trace: &Trace, row: usize| trace.blocks[neck].reference.values[row];
        let trace = read(NOD, &robot, 1.0).unwrap();
        assert!((at(&trace, 250) - 30_f32.to_radians()).abs() < 1e-6 && at(&trace, 500).abs() < 1e-6);
        assert!((at(&trace, 750) - at(&trace, 250)).abs() < 1e-6, "again after two seconds");
        let fast = read(NOD, &robot, 2.0).unwrap();
        assert_eq!(at(&fast, 125), at(&trace, 250), "twice as fast");
    }

    #[test]
    fn a_body_goes_where_it_is_told_and_feet_stay() {
        let robot = robot("dancebot");
        let text = "seconds = 2.0\n[[pose]]\ntime = 0.0\nbodies.trunk = { x = 0.0, z = 0.0, yaw = 0 }\n\
                    [[pose]]\ntime = 1.0\nbodies.trunk = { x = 0.01, z = -0.01, yaw = 10 }\n";
        let trace = read(text, &robot, 1.0).unwrap();
        let at = |row: usize| {
            let pose: Vec<f64> = trace.blocks.iter().map(|block| f64::from(block.reference.values[row])).collect();
            Inverse::new(&robot.character, &pose).kinematics().clone()
        };
        let (start, end) = (at(0), at(250));
        let [trunk, foot] = ["trunk", "left_foot"].map(|name| robot.character.body(name).unwrap());
        let moved = end.body_position[trunk] - start.body_position[trunk];
        assert!((moved - Vec3::new(0.01, 0.0, -0.01)).norm() < 2e-3, "{moved}");
        assert!(
            (end.body_orientation[trunk].angle_to(&start.body_orientation[trunk]) - 10_f64.to_radians()).abs() < 0.03
        );
        assert!((end.body_position[foot] - start.body_position[foot]).norm() < 5e-4);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let robot = robot("kickbot");
        let refused = |text: &str| read(text, &robot, 1.0).unwrap_err().to_string();
        assert!(refused(&NOD.replace("neck_yaw", "tail")).contains("pose 1: expected joints of 'kickbot'"));
        assert!(refused(&NOD.replace("time = 1.0", "time = 3.0")).contains("pose 2: expected a time above"));
        assert!(refused("seconds = 2.0\npose = []").contains("one or more"));
        assert!(refused(&NOD.replace("seconds", "length")).contains("nod.poses.toml: TOML"));
        let body = "seconds = 1.0\n[[pose]]\ntime = 0.0\nbodies.trunk = { up = 1 }\n";
        assert!(refused(body).contains("body 'trunk': expected [\"x\""));
    }
}
