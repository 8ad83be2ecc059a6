//! Measures of published trackers: HumanTracker's failure rule and joint error, and mjlab's key-body errors.

use lifelike_character::rotation::heading;
use lifelike_character::{Role, Vec3};
use lifelike_robot::Robot;

use super::accuracy::mean;
use super::rollout::{Rollout, Snapshot};

/// Height error of pelvis, ankles or wrists beyond which HumanTracker counts a failure (m).
pub const HEIGHT_LIMIT: f64 = 0.25;
/// Rotation error of the pelvis, heading included, beyond which HumanTracker counts a failure (rad).
pub const ROTATION_LIMIT: f64 = 1.0;

/// Key bodies of mjlab's Unitree G1, in its names; the torso is the anchor.
const MJLAB_G1: [&str; 14] = [
    "torso_link",
    "pelvis",
    "left_hip_roll_link",
    "left_knee_link",
    "left_ankle_roll_link",
    "right_hip_roll_link",
    "right_knee_link",
    "right_ankle_roll_link",
    "left_shoulder_roll_link",
    "left_elbow_link",
    "left_wrist_yaw_link",
    "right_shoulder_roll_link",
    "right_elbow_link",
    "right_wrist_yaw_link",
];
/// The same bodies by role, for every other robot; the chest is the anchor.
const KEY_ROLES: [Role; 14] = [
    Role::Chest,
    Role::Pelvis,
    Role::LeftThigh,
    Role::LeftShank,
    Role::LeftFoot,
    Role::RightThigh,
    Role::RightShank,
    Role::RightFoot,
    Role::LeftUpperArm,
    Role::LeftForearm,
    Role::LeftHand,
    Role::RightUpperArm,
    Role::RightForearm,
    Role::RightHand,
];
/// Ankles and wrists: joint centre of a foot, place of a hand.
const WATCHED: [Role; 4] = [Role::LeftFoot, Role::RightFoot, Role::LeftHand, Role::RightHand];

/// Bodies of a robot that the field's measures look at.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FieldBodies {
    /// Points whose heights HumanTracker watches beside the root's: body and point in its frame (m).
    pub watched: Vec<(usize, Vec3)>,
    /// mjlab's key bodies, each once, the anchor first.
    pub keys: Vec<usize>,
}

impl FieldBodies {
    /// Returns the bodies by mjlab's names where the robot has all of them, by role otherwise.
    pub fn of(robot: &Robot) -> Self {
        let (character, places) = (&robot.character, &robot.anatomy.places);
        let named: Option<Vec<usize>> = MJLAB_G1.iter().map(|name| character.body(name).ok()).collect();
        let by_role = || KEY_ROLES.iter().filter_map(|role| places.get(role)).map(|place| place.body);
        let mut keys: Vec<usize> = Vec::new();
        for body in named.unwrap_or_else(|| by_role().collect()) {
            if !keys.contains(&body) {
                keys.push(body);
            }
        }
        let watched = WATCHED.iter().filter_map(|role| places.get(role)).map(|place| (place.body, place.point));
        Self { watched: watched.collect(), keys }
    }
}

/// HumanTracker's verdict on an episode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HumanTracker {
    /// True where no frame failed and the robot did not fall.
    pub success: bool,
    /// Frames before the failure that count.
    pub frames: usize,
    /// Mean absolute joint error over them (rad): its MPJPE.
    pub joint_error_rad: f64,
}

/// Returns HumanTracker's verdict. Heights are those above each one's own ground, errors relative to the reference, so the rule
/// holds for motion on the ground too.
pub fn human_tracker(rollout: &Rollout) -> HumanTracker {
    let watched = &rollout.names.field.watched;
    let before: Vec<_> = rollout.pairs().take_while(|(r, s)| !failed(watched, r, s)).collect();
    let joints = |(r, s): &(&Snapshot, &Snapshot)| mean(r.joints.iter().zip(&s.joints).map(|(a, b)| (a - b).abs()));
    HumanTracker {
        success: rollout.survived() && before.len() == rollout.pairs().count(),
        frames: before.len(),
        joint_error_rad: mean(before.iter().map(joints)),
    }
}

fn failed(watched: &[(usize, Vec3)], reference: &Snapshot, simulated: &Snapshot) -> bool {
    let point = |s: &Snapshot, body: usize, at: &Vec3| (s.bodies[body].0 + s.bodies[body].1 * at).z - s.ground;
    let heights = watched.iter().map(|(body, at)| point(reference, *body, at) - point(simulated, *body, at));
    let root = |s: &Snapshot| s.root_position.z - s.ground;
    let off = heights.chain([root(reference) - root(simulated)]).any(|error| error.abs() > HEIGHT_LIMIT);
    off || reference.root_orientation.angle_to(&simulated.root_orientation) > ROTATION_LIMIT
}

/// Mean distance of the key bodies from the reference in the world over the frames that count (m): mjlab 1.6.0's `mpkpe`. NaN
/// without frames or key bodies.
pub fn mpkpe(rollout: &Rollout) -> f64 {
    let keys = &rollout.names.field.keys;
    let distances =
        |(r, s): (&Snapshot, &Snapshot)| mean(keys.iter().map(|k| (r.bodies[*k].0 - s.bodies[*k].0).norm()));
    mean(rollout.pairs().map(distances).filter(|d| d.is_finite()))
}

/// Mean distance of the key bodies from the reference moved to the robot's anchor (m): mjlab 1.6.0's `r_mpkpe`. The reference is
/// turned by the heading between the anchors and put on the robot's anchor on the ground; its height stays.
pub fn root_relative_mpkpe(rollout: &Rollout) -> f64 {
    let keys = &rollout.names.field.keys;
    let Some(&anchor) = keys.first() else { return f64::NAN };
    let distances = |(r, s): (&Snapshot, &Snapshot)| {
        let (from, to) = (r.bodies[anchor], s.bodies[anchor]);
        let turn = heading(&(to.1 * from.1.inverse()));
        let place = Vec3::new(to.0.x, to.0.y, from.0.z);
        mean(keys.iter().map(|k| (place + turn * (r.bodies[*k].0 - from.0) - s.bodies[*k].0).norm()))
    };
    mean(rollout.pairs().map(distances))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_character::Quat;

    use super::super::rollout::example::{rollout, snapshot};
    use super::super::rollout::{Cause, Outcome};
    use super::*;

    #[test]
    fn the_rule_looks_at_heights_of_hands_and_root_and_at_the_whole_rotation() {
        let of = |simulated: Snapshot| {
            let found = human_tracker(&rollout(3, |_| snapshot(Vec3::z(), 0.0, 0.0), |_| simulated.clone()));
            (found.success, found.frames)
        };
        assert_eq!(of(snapshot(Vec3::new(9.0, 0.0, 1.24), 0.0, 0.0)), (true, 2), "places do not matter");
        assert_eq!(of(snapshot(Vec3::new(0.0, 0.0, 1.26), 0.0, 0.0)), (false, 0));
        assert_eq!(of(snapshot(Vec3::z(), 0.99, 0.0)), (true, 2));
        assert_eq!(of(snapshot(Vec3::z(), 1.01, 0.0)), (false, 0), "heading counts");
        let mut hand = snapshot(Vec3::z(), 0.0, 0.0);
        hand.bodies[2].0.z -= 0.26;
        assert_eq!(of(hand.clone()), (false, 0));
        hand.ground = -0.1;
        assert_eq!(of(hand), (true, 2), "0.16 m lower above its own ground");
    }

    #[test]
    fn joint_errors_count_until_the_failure_and_a_fall_is_one() {
        // Joint errors of 0.1 t; the root sinks by a metre a second: 0.3 m at t = 0.3 s.
        let sinks = |t: f64| snapshot(Vec3::new(0.0, 0.0, 1.0 - t), 0.0, 0.1 * t);
        let mut r = rollout(6, |_| snapshot(Vec3::z(), 0.0, 0.0), sinks);
        let found = human_tracker(&r);
        assert_eq!((found.success, found.frames), (false, 2));
        assert!((found.joint_error_rad - 0.015).abs() < 1e-12, "{found:?}");
        r = rollout(6, |_| snapshot(Vec3::z(), 0.0, 0.0), |_| snapshot(Vec3::z(), 0.0, 0.0));
        assert!(human_tracker(&r).success);
        r.outcome = Outcome::Fell { frame: 4, cause: Cause::Height };
        assert_eq!((human_tracker(&r).success, human_tracker(&r).frames), (false, 3));
    }

    #[test]
    fn key_bodies_in_the_world_and_beside_the_anchor() {
        // The robot stands 2 m aside, a quarter turn to the left and 0.1 m lower than asked: from (1, 0, 1.5) its hand is at
        // (0, 3, 1.4); the pelvis, which is the anchor, is off by (0, 2, -0.1).
        let place = Vec3::new(0.0, 2.0, 0.9);
        let turned = move |_| snapshot(place, std::f64::consts::FRAC_PI_2, 0.0);
        let r = rollout(3, |_| snapshot(Vec3::z(), 0.0, 0.0), turned);
        let world = (4.01_f64.sqrt() + (1.0_f64 + 9.0 + 0.01).sqrt()) / 2.0;
        assert!((mpkpe(&r) - world).abs() < 1e-12, "{}", mpkpe(&r));
        // Place and heading are taken out, the height is not.
        assert!((root_relative_mpkpe(&r) - 0.1).abs() < 1e-12, "{}", root_relative_mpkpe(&r));
        // A tilt stays, too: the hand goes from (1, 0, 0.5) to (cos 0.3 + 0.5 sin 0.3, 0, 0.5 cos 0.3 - sin 0.3).
        let tilted = |_| {
            let mut s = snapshot(Vec3::z(), 0.0, 0.0);
            let tilt = Quat::from_euler_angles(0.0, 0.3, 0.0);
            s.bodies[1].1 = tilt;
            s.bodies[2].0 = Vec3::z() + tilt * Vec3::new(1.0, 0.0, 0.5);
            s
        };
        let r = rollout(3, |_| snapshot(Vec3::z(), 0.0, 0.0), tilted);
        let (sin, cos) = 0.3_f64.sin_cos();
        let hand = (cos + 0.5 * sin - 1.0).hypot(0.5 * cos - sin - 0.5);
        assert!((root_relative_mpkpe(&r) - hand / 2.0).abs() < 1e-12, "{}", root_relative_mpkpe(&r));
    }

    #[test]
    fn bodies_are_found_by_role() {
        let lima = Robot::load("lima").unwrap();
        let bodies = FieldBodies::of(&lima);
        assert_eq!(bodies.watched.len(), 4);
        assert_eq!(bodies.keys[0], lima.anatomy.places[&Role::Chest].body);
        assert!((8..=14).contains(&bodies.keys.len()), "{}", bodies.keys.len());
    }
}
