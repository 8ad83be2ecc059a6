//! Getting up by a script: keyframes of joint targets, played from the belly, until a controller may take over.
//!
//! ```text
//! lie → rise → on its feet     on the belly
//! lie → roll → rise            else
//! rise or roll → lie           where it failed
//! ```
//! A script is TOML beside the robot's description. Small humanoids have been sold with such keyframes for twenty years. They do
//! not balance: a controller takes over as soon as the robot is on its feet.

use std::sync::Arc;

use lifelike_character::rotation::from_wxyz;
use lifelike_character::{Kinematics, Symmetry, Vec3};

use crate::observation::MeasuredState;
use crate::robot::Robot;
use crate::{FromInput, RobotError};

/// A robot lies on its belly when the vertical part of its forward axis is below this.
const ON_BELLY: f64 = -0.6;
/// A robot that rises has failed when it is above this.
const ON_BACK: f64 = 0.7;
/// Least vertical part of the up axis of a robot that is on its feet.
const UPRIGHT: f64 = 0.9;
/// Least height of its root above its soles, as a share of the default pose's.
const HEIGHT_SHARE: f64 = 0.75;

/// A pose, and the time to reach it.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Key {
    /// Time from the pose before (s).
    pub seconds: f64,
    /// Joint targets (rad), in the order of [`GetUpScript::joints`].
    pub pose: Vec<f32>,
}

/// Keyframes of getting up. The robot's x axis points forward.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GetUpScript {
    /// Names of the joints.
    pub joints: Vec<String>,
    /// Stretching out, so that the robot comes to lie flat.
    pub lie: Vec<Key>,
    /// From the back or the right side to the belly; mirrored from the left side.
    pub roll: Vec<Key>,
    /// From the belly to the feet.
    pub rise: Vec<Key>,
}

impl GetUpScript {
    /// Reads a script.
    ///
    /// # Errors
    /// [`RobotError::Input`] where the text is no script.
    pub fn parse(text: &str) -> Result<Self, RobotError> {
        toml::from_str(text).map_err(|error| RobotError::mismatch("get-up script", "TOML of its keys", error.message()))
    }

    /// Returns the script of a robot that comes with the program; none where it has none.
    pub fn builtin(robot: &str) -> Option<&'static str> {
        match robot {
            "lima" => Some(include_str!("../robots/lima.get-up.toml")),
            "g1" => Some(include_str!("../robots/g1.get-up.toml")),
            _ => None,
        }
    }

    /// Returns the keys of a stage.
    fn keys(&self, stage: Stage) -> &[Key] {
        match stage {
            Stage::Lie => &self.lie,
            Stage::Roll => &self.roll,
            Stage::Rise => &self.rise,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    Lie,
    Roll,
    Rise,
}

/// A script at work on one robot.
#[derive(Debug, Clone)]
pub struct GetUp {
    robot: Arc<Robot>,
    script: Arc<GetUpScript>,
    symmetry: Arc<Symmetry>,
    kinematics: Kinematics,
    /// Generalised position of the measured joints, the root at the origin.
    position: Vec<f64>,
    /// Least height of the root above the soles (m).
    height: f64,
    stage: Stage,
    mirrored: bool,
    /// The present key, and the time since the one before (s).
    key: usize,
    elapsed: f64,
    /// The pose of the key before, `[J]` (rad).
    from: Vec<f32>,
    mirror: Vec<f32>,
}

impl GetUp {
    /// Makes it for a robot.
    ///
    /// # Errors
    /// The script has other joints, a stage without keys, or numbers that are not finite; the robot is not symmetric.
    pub fn new(script: &GetUpScript, robot: Arc<Robot>) -> Result<Self, RobotError> {
        if script.joints != robot.layout.joints {
            let got = script.joints.join(", ");
            return Err(RobotError::mismatch("joints of the get-up script", robot.layout.joints.join(", "), got));
        }
        for (name, keys) in [("lie", &script.lie), ("roll", &script.roll), ("rise", &script.rise)] {
            let is_good = |key: &Key| {
                let finite = key.pose.iter().all(|angle| angle.is_finite());
                key.pose.len() == robot.joints() && finite && (1e-3..=60.0).contains(&key.seconds)
            };
            if keys.is_empty() || !keys.iter().all(is_good) {
                let expected = format!("keys of {} finite angles and 0.001 to 60 s", robot.joints());
                return Err(RobotError::mismatch(format!("stage '{name}' of the get-up script"), expected, "others"));
            }
        }
        let symmetry = Arc::new(Symmetry::derive(&robot.character)?);
        let joints = robot.joints();
        let mut own = Self {
            kinematics: Kinematics::new(&robot.character),
            position: robot.default_position(),
            height: 0.0,
            stage: Stage::Lie,
            mirrored: false,
            key: 0,
            elapsed: 0.0,
            from: vec![0.0; joints],
            mirror: vec![0.0; joints],
            script: Arc::new(script.clone()),
            symmetry,
            robot,
        };
        let standing: Vec<f32> = own.robot.default_pose.iter().map(|angle| *angle as f32).collect();
        own.height = HEIGHT_SHARE * own.height_above_soles(&standing, [1.0, 0.0, 0.0, 0.0]);
        Ok(own)
    }

    /// Returns the number of joints.
    pub fn joints(&self) -> usize {
        self.from.len()
    }

    /// Begins with the joints where they are (rad).
    pub fn begin(&mut self, joints: &[f32]) {
        self.mirrored = false;
        self.from.copy_from_slice(joints);
        self.enter(Stage::Lie);
    }

    /// Returns whether the robot is on its feet, so that a controller may take over.
    pub fn is_on_its_feet(&mut self, measured: &MeasuredState<'_>) -> bool {
        self.stage == Stage::Rise
            && vertical(measured.root_orientation, &Vec3::z()) > UPRIGHT
            && self.height_above_soles(measured.joint_position, measured.root_orientation) > self.height
    }

    /// Writes the joint targets (rad) of the next policy step.
    pub fn step(&mut self, measured: &MeasuredState<'_>, targets: &mut [f32]) {
        let forward = vertical(measured.root_orientation, &Vec3::x());
        if self.stage == Stage::Rise && forward > ON_BACK {
            self.from.copy_from_slice(measured.joint_position);
            self.enter(Stage::Lie);
        }
        self.elapsed += 1.0 / self.robot.control_hz;
        while self.elapsed > self.script.keys(self.stage)[self.key].seconds {
            self.elapsed -= self.script.keys(self.stage)[self.key].seconds;
            self.pose(targets);
            self.from.copy_from_slice(targets);
            self.key += 1;
            if self.key == self.script.keys(self.stage).len() {
                let left = vertical(measured.root_orientation, &Vec3::y());
                self.mirrored = left < 0.0 && self.stage != Stage::Rise;
                self.enter(match self.stage {
                    Stage::Lie | Stage::Roll if forward < ON_BELLY => Stage::Rise,
                    Stage::Lie => Stage::Roll,
                    Stage::Roll | Stage::Rise => Stage::Lie,
                });
            }
        }
        self.pose(targets);
        let share = (self.elapsed / self.script.keys(self.stage)[self.key].seconds).min(1.0) as f32;
        let weight = share * share * (3.0 - 2.0 * share);
        for (target, from) in targets.iter_mut().zip(&self.from) {
            *target = from + (*target - from) * weight;
        }
    }

    fn enter(&mut self, stage: Stage) {
        (self.stage, self.key, self.elapsed) = (stage, 0, 0.0);
    }

    /// Writes the pose of the present key, mirrored where the robot is.
    fn pose(&mut self, out: &mut [f32]) {
        let pose = &self.script.keys(self.stage)[self.key].pose;
        if !(self.mirrored && self.stage == Stage::Roll) {
            out.copy_from_slice(pose);
            return;
        }
        for (joint, (partner, sign)) in self.symmetry.joint.iter().zip(&self.symmetry.sign).enumerate() {
            self.mirror[*partner] = *sign as f32 * pose[joint];
        }
        out.copy_from_slice(&self.mirror);
    }

    /// Returns the height of the root above the lowest point of its soles (m).
    fn height_above_soles(&mut self, joints: &[f32], orientation: [f32; 4]) -> f64 {
        let character = &self.robot.character;
        let Some(root) = character.root_joint().map(|joint| (joint.q_index, joint.body)) else { return 0.0 };
        for (joint, angle) in character.scalar_joints().zip(joints) {
            self.position[joint.q_index] = f64::from(*angle);
        }
        for (q, part) in self.position[root.0 + 3..root.0 + 7].iter_mut().zip(orientation) {
            *q = f64::from(part);
        }
        self.kinematics.update(character, &self.position);
        let soles = self.robot.anatomy.soles.values();
        let corners = soles.flat_map(|sole| sole.corners.iter().map(|corner| (sole.body, corner)));
        let lowest = corners.map(|(body, corner)| self.kinematics.point(body, corner).z).fold(f64::INFINITY, f64::min);
        self.kinematics.body_position[root.1].z - lowest
    }
}

/// Returns the vertical part of an axis of the root.
fn vertical(orientation: [f32; 4], axis: &Vec3) -> f64 {
    from_wxyz(orientation.map(f64::from)).map_or(0.0, |turn| (turn * axis).z)
}
