//! The parts of an observation, each declared once: name, size, sensor, and how its numbers are written.

use std::ops::Range;

use lifelike_character::rotation::{Turn, from_wxyz};
use nalgebra::{UnitQuaternion, Vector3};

use super::chain::Pose;
use super::inputs::ObservationInputs;
use super::spec::ObservationSpec;
use crate::{FromInput, RobotError};

/// A sensor, or an estimator in its place, that a part comes from: what a sensor model gives noise and delays to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sensor {
    /// Height of the root above the ground.
    RootHeight,
    /// Orientation of the root (IMU).
    RootOrientation,
    /// Linear velocity of the root.
    RootLinearVelocity,
    /// Angular velocity of the root (gyroscope).
    RootAngularVelocity,
    /// Joint encoders.
    JointPosition,
    /// Joint encoders, differentiated.
    JointVelocity,
    /// Forward kinematics of encoders and IMU.
    KeyBodies,
    /// Heading against the reference's: an IMU whose drift somebody corrects.
    Heading,
    /// Place against the reference's: motion capture or odometry.
    Place,
}

impl Sensor {
    /// Returns true for what a robot with encoders and an IMU measures by itself; the rest wants an estimator.
    pub fn is_on_board(self) -> bool {
        use Sensor::{JointPosition, JointVelocity, KeyBodies, RootAngularVelocity, RootOrientation};
        matches!(self, RootOrientation | RootAngularVelocity | JointPosition | JointVelocity | KeyBodies)
    }
}

/// Origin of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// Measured, and so noisy and late.
    Measured(Sensor),
    /// The policy's own outputs.
    Action,
    /// The motion to follow.
    Reference,
    /// Own states and actions of earlier steps, as they were seen then.
    Past,
}

impl Source {
    /// Returns true for the robot's own state and actions, whatever it is asked to do.
    pub fn is_own_state(self) -> bool {
        match self {
            Self::Measured(sensor) => !matches!(sensor, Sensor::Heading | Sensor::Place),
            Self::Action => true,
            Self::Reference | Self::Past => false,
        }
    }
}

/// A part of one layout.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// Its name.
    pub name: String,
    /// Its numbers in an observation.
    pub range: Range<usize>,
    /// Its origin.
    pub source: Source,
}

/// The times that a part occurs in a layout.
pub(super) enum Occurs<'a> {
    Once(bool),
    Ahead(&'a [u32]),
    Around(&'a [i32]),
}

impl Occurs<'_> {
    pub(super) fn count(&self) -> usize {
        match self {
            Self::Once(there) => usize::from(*there),
            Self::Ahead(offsets) => offsets.len(),
            Self::Around(offsets) => offsets.len(),
        }
    }

    pub(super) fn name(&self, name: &str, i: usize) -> String {
        match self {
            Self::Once(_) => name.into(),
            Self::Ahead(offsets) => format!("{name}{:+}", offsets[i]),
            Self::Around(offsets) => format!("{name}{:+}", offsets[i]),
        }
    }
}

/// Numbers of one part that cannot be written.
pub(super) enum Wrong {
    Length { expected: usize, got: usize },
    Unmeasured(&'static str),
    Frames(RobotError),
}

impl Wrong {
    pub(super) fn of(self, part: &str) -> RobotError {
        match self {
            Self::Length { expected, got } => RobotError::mismatch(format!("length of {part}"), expected, got),
            Self::Unmeasured(needed) => RobotError::Unmeasured { part: part.into(), needed },
            Self::Frames(error) => error,
        }
    }
}

/// Everything that the parts of one observation share.
pub(super) struct Scene<'a> {
    inputs: &'a ObservationInputs<'a>,
    root: UnitQuaternion<f32>,
    to_heading: Turn<f32>,
    /// Without a measurement of it, everything is relative to the root.
    position: Vector3<f32>,
}

/// The anchor bodies of robot and reference, in the robot's world.
struct Anchors {
    own: Pose,
    reference: Pose,
}

impl<'a> Scene<'a> {
    pub(super) fn new(inputs: &'a ObservationInputs<'a>) -> Self {
        let root = orientation(inputs.measured.root_orientation);
        let position = Vector3::from(inputs.measured.root_position.unwrap_or_default());
        Self { inputs, root, to_heading: Turn::heading(&root).inverse(), position }
    }

    /// Joint positions and velocities of the reference's PRESENT frame, `[J]` each.
    fn reference_joints(&self, spec: &ObservationSpec) -> (&'a [f32], &'a [f32]) {
        let (frame, joints) = (self.inputs.reference.ahead(0), spec.joints.len());
        frame.get(13..13 + 2 * joints).unwrap_or_default().split_at_checked(joints).unwrap_or_default()
    }

    /// The PRESENT orientation of the reference's root, in the robot's world.
    fn reference_root(&self) -> UnitQuaternion<f32> {
        orientation(self.inputs.alignment.orientation(self.inputs.reference.present_root().orientation))
    }

    /// A vector of the reference's PRESENT frame, in the frame of its root. Frames are written in their heading's frame.
    fn in_reference_root(&self, spec: &ObservationSpec, range: Range<usize>) -> Result<Vector3<f32>, Wrong> {
        let frame = self.inputs.reference.ahead(0);
        let vector = frame.get(range).ok_or(Wrong::Length { expected: spec.frame_size(), got: frame.len() })?;
        let root = orientation(self.inputs.reference.present_root().orientation);
        Ok(root.inverse() * Turn::heading(&root).apply(Vector3::from_column_slice(vector)))
    }

    fn anchors(&self, spec: &ObservationSpec) -> Anchors {
        let &ObservationInputs { measured, joint_offset, reference, alignment, .. } = self.inputs;
        let angle = |j: usize| {
            measured.joint_position.get(j).map_or(f32::NAN, |q| q + joint_offset.get(j).copied().unwrap_or(0.0))
        };
        let own = spec.anchor_chain.pose((self.position, self.root), angle);
        let (joints, _) = self.reference_joints(spec);
        let root = (Vector3::from(alignment.position(reference.present_root().position)), self.reference_root());
        let reference = spec.anchor_chain.pose(root, |j| joints.get(j).copied().unwrap_or(f32::NAN));
        Anchors { own, reference }
    }
}

/// One declaration.
pub(super) struct Declaration {
    pub(super) name: &'static str,
    pub(super) source: Source,
    pub(super) occurs: fn(&ObservationSpec) -> Occurs<'_>,
    pub(super) size: fn(&ObservationSpec) -> usize,
    pub(super) write: fn(&ObservationSpec, &Scene<'_>, usize, &mut [f32]) -> Result<(), Wrong>,
}

impl Declaration {
    /// Returns true for what `inputs.history` repeats of earlier steps: sensors, and the last action.
    ///
    /// Key bodies follow from the joints, and the action before from the step before.
    pub(super) fn is_remembered(&self) -> bool {
        match self.source {
            Source::Measured(sensor) => !matches!(sensor, Sensor::KeyBodies | Sensor::Heading | Sensor::Place),
            Source::Action => self.name == "last_action",
            Source::Reference | Source::Past => false,
        }
    }
}

fn always(_: &ObservationSpec) -> Occurs<'_> {
    Occurs::Once(true)
}

fn joints(spec: &ObservationSpec) -> usize {
    spec.joints.len()
}

/// All parts, in the order of their numbers. A new part is one entry here that occurs where a layout has it `named`,
/// so that older policies keep their layout. Plans ask for it in `inputs.parts`, or in `inputs.terms`, which is a
/// whole layout. History and window stay last: an encoder takes one of them from the end.
pub(super) const PARTS: &[Declaration] = &[
    Declaration {
        name: "root_height",
        source: Source::Measured(Sensor::RootHeight),
        occurs: |spec| Occurs::Once(spec.root_height),
        size: |_| 1,
        write: |_, scene, _, out| {
            let measured = scene.inputs.measured;
            let height = measured.root_height.or(measured.root_position.map(|p| p[2]));
            copy(&[height.ok_or(Wrong::Unmeasured("the root's height or position"))?], out)
        },
    },
    Declaration {
        name: "root_orientation_h",
        source: Source::Measured(Sensor::RootOrientation),
        occurs: always,
        size: |_| 6,
        write: |_, scene, _, out| copy(&scene.to_heading.apply_6d(&scene.root), out),
    },
    Declaration {
        name: "root_linear_velocity_h",
        source: Source::Measured(Sensor::RootLinearVelocity),
        occurs: |spec| Occurs::Once(spec.linear_velocity),
        size: |_| 3,
        write: |_, scene, _, out| {
            let velocity = scene.inputs.measured.linear_velocity_w;
            let velocity = velocity.ok_or(Wrong::Unmeasured("the root's linear velocity"))?;
            copy(scene.to_heading.apply(Vector3::from(velocity)).as_slice(), out)
        },
    },
    Declaration {
        name: "root_angular_velocity_h",
        source: Source::Measured(Sensor::RootAngularVelocity),
        occurs: always,
        size: |_| 3,
        write: |_, scene, _, out| {
            copy(scene.to_heading.apply(Vector3::from(scene.inputs.measured.angular_velocity_w)).as_slice(), out)
        },
    },
    Declaration {
        name: "joint_position",
        source: Source::Measured(Sensor::JointPosition),
        occurs: always,
        size: joints,
        write: |spec, scene, _, out| {
            let (measured, offset) = (scene.inputs.measured.joint_position, scene.inputs.joint_offset);
            copy(measured, out)?;
            if !offset.is_empty() && offset.len() != out.len() {
                return Err(Wrong::Length { expected: out.len(), got: offset.len() });
            }
            out.iter_mut().zip(offset).for_each(|(q, offset)| *q += offset);
            out.iter_mut().zip(&spec.default_pose).for_each(|(q, origin)| *q -= origin);
            Ok(())
        },
    },
    Declaration {
        name: "joint_velocity",
        source: Source::Measured(Sensor::JointVelocity),
        occurs: always,
        size: joints,
        write: |_, scene, _, out| copy(scene.inputs.measured.joint_velocity, out),
    },
    Declaration {
        name: "key_bodies_h",
        source: Source::Measured(Sensor::KeyBodies),
        occurs: always,
        size: |spec| 3 * spec.key_bodies.len(),
        write: |_, scene, _, out| {
            if out.is_empty() {
                return Ok(());
            }
            let places = scene.inputs.measured.key_bodies_w.ok_or(Wrong::Unmeasured("the key bodies"))?;
            copy(places, out)?;
            for p in out.as_chunks_mut::<3>().0 {
                *p = scene.to_heading.apply(Vector3::from(*p) - scene.position).into();
            }
            Ok(())
        },
    },
    Declaration {
        name: "last_action",
        source: Source::Action,
        occurs: always,
        size: joints,
        write: |_, scene, _, out| copy(scene.inputs.last_action, out),
    },
    Declaration {
        name: "action_before",
        source: Source::Action,
        occurs: always,
        size: joints,
        write: |_, scene, _, out| copy(scene.inputs.action_before, out),
    },
    Declaration {
        name: "reference",
        source: Source::Reference,
        occurs: |spec| Occurs::Once(spec.reference.frame),
        size: ObservationSpec::frame_size,
        write: |spec, scene, _, out| frame(spec, scene.inputs.reference.around(0), out),
    },
    Declaration {
        name: "reference",
        source: Source::Reference,
        occurs: |spec| Occurs::Ahead(&spec.reference.future),
        size: ObservationSpec::frame_size,
        write: |spec, scene, i, out| frame(spec, scene.inputs.reference.ahead(spec.reference.future[i]), out),
    },
    Declaration {
        name: "latent",
        source: Source::Reference,
        occurs: always,
        size: |spec| spec.reference.latent,
        write: |_, scene, _, out| copy(scene.inputs.latent, out),
    },
    Declaration {
        name: "anchor_heading",
        source: Source::Measured(Sensor::Heading),
        occurs: |spec| Occurs::Once(spec.anchor.heading),
        size: |_| 2,
        write: |_, scene, _, out| {
            let target = scene.inputs.alignment.laid().heading(scene.inputs.reference.root().orientation);
            let error = target.and(scene.to_heading);
            let limit = Turn::by(ObservationSpec::ANCHOR_TURN);
            let beyond = error.cos < limit.cos;
            copy(&if beyond { [limit.sin.copysign(error.sin), limit.cos] } else { [error.sin, error.cos] }, out)
        },
    },
    Declaration {
        name: "anchor_position",
        source: Source::Measured(Sensor::Place),
        occurs: |spec| Occurs::Once(spec.anchor.position),
        size: |_| 2,
        write: |_, scene, _, out| {
            let position = scene.inputs.measured.root_position.ok_or(Wrong::Unmeasured("the root's position"))?;
            let target = scene.inputs.alignment.position(scene.inputs.reference.root().position);
            let [x, y] = scene.to_heading.on_ground([target[0] - position[0], target[1] - position[1]]);
            let reach = ObservationSpec::ANCHOR_REACH;
            let share = reach / (x * x + y * y).sqrt().max(reach);
            copy(&[share * x, share * y], out)
        },
    },
    Declaration {
        name: "projected_gravity_b",
        source: Source::Measured(Sensor::RootOrientation),
        occurs: |spec| spec.named("projected_gravity_b"),
        size: |_| 3,
        write: |_, scene, _, out| copy((scene.root.inverse() * -Vector3::z()).as_slice(), out),
    },
    // The terms of other stacks, seen where a layout names them. "Present" is the frame in which the robot should
    // be now; `reference` above is the one that it shall reach.
    Declaration {
        name: "root_linear_velocity_b",
        source: Source::Measured(Sensor::RootLinearVelocity),
        occurs: |spec| spec.named("root_linear_velocity_b"),
        size: |_| 3,
        write: |_, scene, _, out| {
            let velocity = scene.inputs.measured.linear_velocity_w;
            let velocity = velocity.ok_or(Wrong::Unmeasured("the root's linear velocity"))?;
            copy((scene.root.inverse() * Vector3::from(velocity)).as_slice(), out)
        },
    },
    Declaration {
        name: "root_angular_velocity_b",
        source: Source::Measured(Sensor::RootAngularVelocity),
        occurs: |spec| spec.named("root_angular_velocity_b"),
        size: |_| 3,
        write: |_, scene, _, out| {
            let velocity = Vector3::from(scene.inputs.measured.angular_velocity_w);
            copy((scene.root.inverse() * velocity).as_slice(), out)
        },
    },
    Declaration {
        name: "reference_joint_position",
        source: Source::Reference,
        occurs: |spec| spec.named("reference_joint_position"),
        size: joints,
        write: |spec, scene, _, out| copy(scene.reference_joints(spec).0, out),
    },
    Declaration {
        name: "reference_joint_velocity",
        source: Source::Reference,
        occurs: |spec| spec.named("reference_joint_velocity"),
        size: joints,
        write: |spec, scene, _, out| copy(scene.reference_joints(spec).1, out),
    },
    Declaration {
        name: "reference_height",
        source: Source::Reference,
        occurs: |spec| spec.named("reference_height"),
        size: |_| 1,
        write: |_, scene, _, out| copy(&[scene.inputs.reference.present_root().position[2]], out),
    },
    Declaration {
        name: "reference_linear_velocity_b",
        source: Source::Reference,
        occurs: |spec| spec.named("reference_linear_velocity_b"),
        size: |_| 3,
        write: |spec, scene, _, out| copy(scene.in_reference_root(spec, 7..10)?.as_slice(), out),
    },
    Declaration {
        name: "reference_angular_velocity_b",
        source: Source::Reference,
        occurs: |spec| spec.named("reference_angular_velocity_b"),
        size: |_| 3,
        write: |spec, scene, _, out| copy(scene.in_reference_root(spec, 10..13)?.as_slice(), out),
    },
    Declaration {
        name: "reference_gravity_b",
        source: Source::Reference,
        occurs: |spec| spec.named("reference_gravity_b"),
        size: |_| 3,
        write: |_, scene, _, out| copy((scene.reference_root().inverse() * -Vector3::z()).as_slice(), out),
    },
    Declaration {
        name: "anchor_position_b",
        source: Source::Measured(Sensor::Place),
        occurs: |spec| spec.named("anchor_position_b"),
        size: |_| 3,
        write: |spec, scene, _, out| {
            if scene.inputs.measured.root_position.is_none() {
                return Err(Wrong::Unmeasured("the root's position"));
            }
            let Anchors { own, reference } = scene.anchors(spec);
            copy((own.1.inverse() * (reference.0 - own.0)).as_slice(), out)
        },
    },
    Declaration {
        name: "anchor_orientation_b",
        source: Source::Measured(Sensor::Heading),
        occurs: |spec| spec.named("anchor_orientation_b"),
        size: |_| 6,
        write: |spec, scene, _, out| {
            let Anchors { own, reference } = scene.anchors(spec);
            // The first two columns, row by row.
            let m = (own.1.inverse() * reference.1).to_rotation_matrix().into_inner();
            copy(&[m.m11, m.m12, m.m21, m.m22, m.m31, m.m32], out)
        },
    },
    Declaration {
        name: "history",
        source: Source::Past,
        occurs: |spec| Occurs::Once(spec.reference.history > 0),
        size: ObservationSpec::history_size,
        write: |_, scene, _, out| match scene.inputs.past {
            // Before the first step: `Memory::recall` fills it in.
            [] => {
                out.fill(0.0);
                Ok(())
            }
            past => copy(past, out),
        },
    },
    Declaration {
        name: "window",
        source: Source::Reference,
        occurs: |spec| Occurs::Around(&spec.reference.window),
        size: ObservationSpec::frame_size,
        write: |spec, scene, i, out| frame(spec, scene.inputs.reference.around(spec.reference.window[i]), out),
    },
];

fn copy(values: &[f32], out: &mut [f32]) -> Result<(), Wrong> {
    if values.len() != out.len() {
        return Err(Wrong::Length { expected: out.len(), got: values.len() });
    }
    out.copy_from_slice(values);
    Ok(())
}

fn frame(spec: &ObservationSpec, features: &[f32], out: &mut [f32]) -> Result<(), Wrong> {
    spec.write_frames(features, out).map_err(Wrong::Frames)
}

/// The rotation, or NaN where the numbers have no direction.
fn orientation(wxyz: [f32; 4]) -> UnitQuaternion<f32> {
    from_wxyz(wxyz).unwrap_or_else(|| {
        UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(f32::NAN, f32::NAN, f32::NAN, f32::NAN))
    })
}
