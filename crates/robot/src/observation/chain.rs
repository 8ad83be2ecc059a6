//! The way from the root to a body: what places an anchor body by the joints' angles.

use lifelike_character::rotation::{from_wxyz, to_wxyz};
use lifelike_character::{Character, JointKind};
use nalgebra::{UnitQuaternion, Vector3};

/// Bodies and hinges between the root and an anchor body. Without links the anchor is the root itself.
///
/// A layout carries it, so that an observation needs no model of the robot.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chain {
    /// Name of the body at its end.
    pub body: String,
    /// Frames from the root on.
    pub links: Vec<Link>,
}

/// One body, or one further hinge of it.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Link {
    /// Position in the frame before (m).
    pub position: [f32; 3],
    /// Orientation in the frame before (`wxyz`).
    pub orientation: [f32; 4],
    /// The hinge that moves it.
    pub hinge: Option<Hinge>,
}

/// A hinge of a [`Link`].
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hinge {
    /// Number of the joint among the robot's.
    pub joint: usize,
    /// Unit axis.
    pub axis: [f32; 3],
    /// A point on the axis (m).
    pub anchor: [f32; 3],
    /// Angle at which it does not turn (rad).
    pub zero: f32,
}

/// Position (m) and orientation of a body.
pub(super) type Pose = (Vector3<f32>, UnitQuaternion<f32>);

impl Chain {
    /// Returns the way to a body; none where the robot has no such body, or it is behind a joint that is no hinge. An empty
    /// name is the root's.
    pub fn to(character: &Character, body: &str) -> Option<Self> {
        let mut links = Vec::new();
        let root = character.bodies.iter().position(|b| b.parent == 0 && b.name != "world")?;
        if body.is_empty() || character.bodies[root].name == body {
            return Some(Self { body: body.into(), links });
        }
        let mut at = character.bodies.iter().position(|b| b.name == body)?;
        while at != root {
            if at == 0 {
                return None;
            }
            let of = &character.bodies[at];
            let mut own = vec![Link {
                position: of.position.map(|x| x as f32).into(),
                orientation: to_wxyz(&of.orientation).map(|x| x as f32),
                hinge: None,
            }];
            for joint in &character.joints[of.joints.clone()] {
                if joint.kind != JointKind::Hinge {
                    return None;
                }
                let hinge = Hinge {
                    joint: character.scalar_joints().position(|other| other.name == joint.name)?,
                    axis: joint.axis.map(|x| x as f32).into(),
                    anchor: joint.position.map(|x| x as f32).into(),
                    zero: joint.reference as f32,
                };
                match own.last_mut().filter(|link| link.hinge.is_none()) {
                    Some(link) => link.hinge = Some(hinge),
                    None => {
                        own.push(Link { position: [0.0; 3], orientation: [1.0, 0.0, 0.0, 0.0], hinge: Some(hinge) })
                    }
                }
            }
            links.splice(0..0, own);
            at = of.parent;
        }
        Some(Self { body: body.into(), links })
    }

    /// Returns true where no anchor is named, and so is the root.
    pub fn is_unnamed(&self) -> bool {
        self.body.is_empty()
    }

    /// Returns true where every hinge is a joint of a robot with this many.
    pub(super) fn fits(&self, joints: usize) -> bool {
        self.links.iter().filter_map(|link| link.hinge.as_ref()).all(|hinge| hinge.joint < joints)
    }

    /// Returns the pose of the anchor for a pose of the root and the angle of each joint.
    pub(super) fn pose(&self, root: Pose, angle: impl Fn(usize) -> f32) -> Pose {
        let (mut position, mut orientation) = root;
        for link in &self.links {
            position += orientation * Vector3::from(link.position);
            orientation *= from_wxyz(link.orientation).unwrap_or_default();
            let Some(Hinge { joint, axis, anchor, zero }) = &link.hinge else { continue };
            let anchor = Vector3::from(*anchor);
            let place = position + orientation * anchor;
            orientation *= UnitQuaternion::from_scaled_axis(Vector3::from(*axis) * (angle(*joint) - zero));
            position = place - orientation * anchor;
        }
        (position, orientation)
    }
}
