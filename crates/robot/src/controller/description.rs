//! The robot that a controller was made for: names, order, default pose, gains, limits, rates, and a digest of them.

use lifelike_checkpoint::Checkpoint;
use sha2::{Digest, Sha256};

use crate::actuator::{ActuatorParameters, friction};
use crate::robot::Robot;
use crate::{FromInput, RobotError};

/// Names of the actuator's numbers, in the order of their columns.
const GAINS: [&str; 8] = [
    "kp",
    "kd",
    "friction_velocity",
    "static_friction",
    "viscous_friction",
    "torque_max",
    "full_torque_velocity",
    "velocity_max",
];
/// Columns of a joint: default angle, range, actuator.
const COLUMNS: usize = 3 + GAINS.len();
/// Columns of a friction under load.
const FRICTION: usize = friction::NUMBERS.len();
/// In files.
const KEY: &str = "robot";

/// Everything about a robot that a policy's behaviour hangs on and that a file can compare.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotDescription {
    /// Joint names, in order.
    pub joints: Vec<String>,
    /// End effectors, in order.
    pub end_effectors: Vec<String>,
    /// Key bodies, in order.
    pub key_bodies: Vec<String>,
    /// Policy rate (Hz).
    pub control_hz: f64,
    /// Physics steps per policy step.
    pub substeps: usize,
    /// SHA-256 over all of it, hexadecimal.
    pub digest: String,
    /// Default angle, least and greatest angle (infinite without limits), actuator parameters, for each joint.
    #[serde(skip)]
    numbers: Vec<[f64; COLUMNS]>,
    /// Friction under load of each joint; empty where no joint has one.
    #[serde(skip)]
    friction: Vec<[f64; FRICTION]>,
}

impl RobotDescription {
    /// Describes a robot.
    pub fn of(robot: &Robot) -> Self {
        let joints = robot.character.scalar_joints().zip(&robot.default_pose).zip(&robot.actuators.parameters);
        let numbers = joints.map(|((joint, pose), a)| {
            let (low, high) = joint.range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
            let [kp, kd, friction, fixed, viscous, torque, full, fastest] = gains(a);
            [*pose, low, high, kp, kd, friction, fixed, viscous, torque, full, fastest]
        });
        let mut description = Self {
            joints: robot.layout.joints.clone(),
            end_effectors: robot.layout.end_effectors.clone(),
            key_bodies: robot.profile.key_bodies.clone(),
            control_hz: robot.control_hz,
            substeps: robot.substeps,
            digest: String::new(),
            numbers: numbers.collect(),
            friction: frictions(&robot.actuators.parameters),
        };
        description.digest = description.sha256();
        description
    }

    fn sha256(&self) -> String {
        let mut hash = Sha256::new();
        for names in [&self.joints, &self.end_effectors, &self.key_bodies] {
            hash.update((names.len() as u64).to_le_bytes());
            for name in names {
                hash.update((name.len() as u64).to_le_bytes());
                hash.update(name.as_bytes());
            }
        }
        hash.update(self.control_hz.to_le_bytes());
        hash.update((self.substeps as u64).to_le_bytes());
        let numbers = self.numbers.iter().flatten().chain(self.friction.iter().flatten());
        numbers.for_each(|x| hash.update(x.to_le_bytes()));
        hash.finalize().iter().map(|b| format!("{b:02x}")).collect()
    }

    /// Checks that a robot is the one described.
    ///
    /// # Errors
    /// The first difference, with the joint's name and both numbers.
    pub fn check(&self, robot: &Robot) -> Result<(), RobotError> {
        let own = Self::of(robot);
        let mismatch = |what: &str, expected: String, got: String| {
            Err(RobotError::mismatch(format!("{what} of robot '{}'", robot.name), expected, got))
        };
        for (what, expected, got) in [
            ("joints", &self.joints, &own.joints),
            ("end effectors", &self.end_effectors, &own.end_effectors),
            ("key bodies", &self.key_bodies, &own.key_bodies),
        ] {
            if expected != got {
                return mismatch(what, expected.join(", "), got.join(", "));
            }
        }
        if self.control_hz != own.control_hz {
            return mismatch("policy rate (Hz)", self.control_hz.to_string(), own.control_hz.to_string());
        }
        if self.substeps != own.substeps {
            return mismatch("physics steps per policy step", self.substeps.to_string(), own.substeps.to_string());
        }
        let columns = ["default angle (rad)", "least angle (rad)", "greatest angle (rad)"].into_iter().chain(GAINS);
        for (joint, (expected, got)) in self.joints.iter().zip(self.numbers.iter().zip(&own.numbers)) {
            for (column, (expected, got)) in columns.clone().zip(expected.iter().zip(got)) {
                if expected != got {
                    return mismatch(&format!("{column} of joint '{joint}'"), expected.to_string(), got.to_string());
                }
            }
        }
        let none = [0.0; FRICTION];
        for (i, joint) in self.joints.iter().enumerate() {
            let [expected, got] = [&self.friction, &own.friction].map(|list| list.get(i).unwrap_or(&none));
            let differing = friction::NUMBERS.iter().zip(expected.iter().zip(got)).find(|(_, (a, b))| a != b);
            if let Some((name, (expected, got))) = differing {
                return mismatch(&format!("{name} of joint '{joint}'"), expected.to_string(), got.to_string());
            }
        }
        if self.digest != own.digest {
            return mismatch("digest", self.digest.clone(), own.digest);
        }
        Ok(())
    }

    pub(super) fn save_into(&self, file: &mut Checkpoint) -> Result<(), RobotError> {
        file.set_meta(KEY, self)?;
        let numbers = self.numbers.iter().flatten().copied().collect();
        file.put_f64(&format!("{KEY}.joints"), &[self.joints.len(), COLUMNS], numbers)?;
        if !self.friction.is_empty() {
            let numbers = self.friction.iter().flatten().copied().collect();
            file.put_f64(&format!("{KEY}.friction"), &[self.joints.len(), FRICTION], numbers)?;
        }
        Ok(())
    }

    pub(super) fn load(file: &Checkpoint) -> Result<Self, RobotError> {
        let mut description: Self = file.meta(KEY)?;
        let numbers = file.f64s(&format!("{KEY}.joints"), &[description.joints.len(), COLUMNS])?;
        description.numbers = numbers.as_chunks::<COLUMNS>().0.to_vec();
        let name = format!("{KEY}.friction");
        if file.contains(&name) {
            let numbers = file.f64s(&name, &[description.joints.len(), FRICTION])?;
            description.friction = numbers.as_chunks::<FRICTION>().0.to_vec();
        }
        let digest = description.sha256();
        if digest != description.digest {
            let what = "digest of the robot in the controller's file";
            return Err(RobotError::mismatch(what, description.digest, digest));
        }
        Ok(description)
    }
}

fn frictions(actuators: &[ActuatorParameters]) -> Vec<[f64; FRICTION]> {
    if actuators.iter().all(|actuator| actuator.extended_friction.is_none()) {
        return Vec::new();
    }
    actuators.iter().map(|actuator| actuator.extended_friction.unwrap_or_default().numbers()).collect()
}

fn gains(a: &ActuatorParameters) -> [f64; 8] {
    [
        a.kp,
        a.kd,
        a.friction_velocity,
        a.static_friction,
        a.viscous_friction,
        a.torque_max,
        a.full_torque_velocity,
        a.velocity_max,
    ]
}
