//! The force law of all actuators of one joint together.

use crate::model::{Actuator, Character};

/// Quantity that an actuator's control sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command {
    /// The force itself: a motor.
    Force,
    /// The joint's position: a servo.
    Position,
    /// The joint's velocity: a servo.
    Velocity,
    /// Nothing that moves: a damper.
    Damping,
}

/// All actuators of one joint: torque = stiffness · (target - position) - damping · velocity, within limits.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Drive {
    /// Stiffness (N m/rad or N/m).
    pub stiffness: f64,
    /// Damping (N m s/rad or N s/m), without the joint's own.
    pub damping: f64,
    /// Smallest and largest torque (N m or N). `None`: unlimited.
    pub torque: Option<(f64, f64)>,
}

impl Actuator {
    /// Returns what the control sets.
    pub fn command(&self) -> Command {
        match self {
            Self { gain: 0.0, .. } => Command::Damping,
            // Its damping is that of the back EMF, not of a servo.
            Self { kind, .. } if kind == "dcmotor" => Command::Force,
            Self { bias: [_, stiffness, _], .. } if *stiffness != 0.0 => Command::Position,
            Self { bias: [_, _, damping], gain, .. } if *damping != 0.0 && *gain == -damping => Command::Velocity,
            _ => Command::Force,
        }
    }

    /// Returns the limits of the joint torque: of the force, and of the control where that is a force (N m).
    pub fn torque_range(&self) -> Option<(f64, f64)> {
        let scaled = |range: Option<(f64, f64)>, factor: f64| {
            range.map(|(low, high)| ((low * factor).min(high * factor), (low * factor).max(high * factor)))
        };
        let control = self.ctrl_range.filter(|_| self.command() == Command::Force);
        overlap(scaled(self.force_range, self.gear), scaled(control, self.gear * self.gain))
    }
}

impl Character {
    /// Returns the sum of all actuators of a joint; `None` where none moves it or damps it without a control.
    pub fn drive(&self, joint: usize) -> Option<Drive> {
        let of_joint = || self.actuators.iter().filter(|a| a.joint == joint);
        let square = |a: &Actuator| a.gear * a.gear;
        let is_moved = of_joint().any(|a| a.command() != Command::Damping);
        let acts = |a: &&Actuator| a.command() != Command::Damping || !is_moved && a.bias[2] != 0.0;
        let mut torque = Some((0.0, 0.0));
        for actuator in of_joint().filter(acts) {
            torque = torque.zip(actuator.torque_range()).map(|(all, own)| (all.0 + own.0, all.1 + own.1));
        }
        of_joint().any(|a| acts(&a)).then(|| Drive {
            stiffness: of_joint().map(|a| -a.bias[1] * square(a)).sum(),
            damping: of_joint().map(|a| -a.bias[2] * square(a)).sum(),
            torque: overlap(torque, self.joints[joint].actuator_force_range),
        })
    }
}

/// Returns what two ranges have in common.
fn overlap(a: Option<(f64, f64)>, b: Option<(f64, f64)>) -> Option<(f64, f64)> {
    match (a, b) {
        (Some(a), Some(b)) => Some((a.0.max(b.0), a.1.min(b.1))),
        (a, b) => a.or(b),
    }
}
