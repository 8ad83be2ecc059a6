//! A robot to look at: what it is drawn with and what it touches with, joints that can be moved, masses and frames.

use lifelike_character::rotation::to_wxyz;
use lifelike_character::{Character, JointKind};
use serde_json::{Value, json};

/// A robot in a pose, for a page whose reader moves its joints.
#[derive(Debug, Clone, Copy)]
pub struct RobotLook<'a> {
    /// The robot.
    pub character: &'a Character,
    /// Generalised position at first (`nq` numbers, MuJoCo's layout).
    pub position: &'a [f64],
    /// Side of each body: 1 left, -1 right, 0 neither, as the program takes it.
    pub sides: &'a [i8],
}

impl RobotLook<'_> {
    /// Returns the tree as the page reads it; the world is body -1.
    pub(super) fn to_json(self) -> Value {
        let Self { character, position, sides } = self;
        let bodies = character.bodies.iter().enumerate().skip(1).map(|(i, body)| {
            json!({
                "name": body.name,
                "parent": body.parent as i64 - 1,
                "position": body.position.as_slice(),
                "orientation": to_wxyz(&body.orientation),
                "mass": body.inertial.mass,
                "com": body.inertial.com.as_slice(),
                "side": sides.get(i).copied().unwrap_or(0),
            })
        });
        let joints = character.joints.iter().map(|joint| {
            let kind = match joint.kind {
                JointKind::Free => "free",
                JointKind::Ball => "ball",
                JointKind::Slide => "slide",
                JointKind::Hinge => "hinge",
            };
            let coupling = joint.coupling.and_then(|index| character.couplings.get(index));
            let numbers = position.get(joint.q_index..joint.q_index + joint.kind.nq());
            json!({
                "name": joint.name,
                "body": joint.body - 1,
                "kind": kind,
                "position": joint.position.as_slice(),
                "axis": joint.axis.as_slice(),
                "range": joint.range,
                "reference": joint.reference,
                "value": numbers.unwrap_or_default(),
                "follows": coupling.map(|coupling| json!({
                    "leader": coupling.leader,
                    "polynomial": coupling.polynomial,
                })),
            })
        });
        json!({ "bodies": bodies.collect::<Vec<_>>(), "joints": joints.collect::<Vec<_>>() })
    }
}
