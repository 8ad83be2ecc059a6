//! Reads snapshots out of simulation and library.

use std::sync::Arc;

use lifelike_character::rotation::from_wxyz;
use lifelike_character::{Character, JointKind, Kinematics, Quat, Vec3};
use lifelike_motion::edit::joints_of;
use lifelike_robot::reference::SOLE_DOWN;
use lifelike_robot::robot::role_name;
use lifelike_robot::{Alignment, ReferenceLibrary, Robot};
use lifelike_sim::{BatchState, Ground};

use super::field::FieldBodies;
use super::rollout::{Names, Outcome, Rollout, Snapshot};
use super::runner::Moment;

/// Writer of rollouts, frame by frame.
pub struct Recorder<'a> {
    robot: &'a Robot,
    library: &'a ReferenceLibrary,
    lift: &'a [f64],
    names: Arc<Names>,
    torque_max: Vec<f32>,
    /// Continuous torques squared (N² m²).
    continuous_squared: Vec<f32>,
    weight: f32,
}

impl<'a> Recorder<'a> {
    /// Returns a recorder. `lift` is the height above level ground at which each frame of the library stands (m); empty: 0.
    pub fn new(robot: &'a Robot, library: &'a ReferenceLibrary, lift: &'a [f64]) -> Self {
        let character = &robot.character;
        // A robot without legs has only upper joints.
        let legs = joints_of(character, &robot.anatomy, &["legs".to_string()]).unwrap_or_default();
        let names = Names {
            legs: robot.layout.joints.iter().map(|joint| legs.contains(joint)).collect(),
            joints: robot.layout.joints.clone(),
            effectors: robot.layout.end_effectors.clone(),
            bodies: character.bodies.iter().map(|b| b.name.clone()).collect(),
            feet: robot.anatomy.soles.keys().map(|role| role_name(*role)).collect(),
            field: FieldBodies::of(robot),
            soles: robot.anatomy.soles.values().map(|sole| (sole.body, sole.middle())).collect(),
        };
        Self {
            robot,
            library,
            lift,
            names: Arc::new(names),
            torque_max: robot.actuators.parameters.iter().map(|p| p.torque_max as f32).collect(),
            continuous_squared: robot.continuous_torques().iter().map(|torque| (torque * torque) as f32).collect(),
            weight: ((character.mass() * character.gravity.norm()) as f32).max(1e-3),
        }
    }

    /// Returns an empty rollout from a frame of the library on, of `planned` frames.
    pub fn begin(&self, frame: usize, planned: usize) -> Rollout {
        let clip = self.library.clip_of(frame);
        Rollout {
            clip: self.library.names[clip].clone(),
            start: (frame - self.library.range(clip).start) as f64 / self.robot.control_hz,
            fps: self.robot.control_hz,
            names: Arc::clone(&self.names),
            reference: Vec::with_capacity(planned),
            simulated: Vec::with_capacity(planned),
            torque_share: Vec::new(),
            heat: Vec::new(),
            foot_force: Vec::new(),
            sole_speed: Vec::new(),
            planned_contact: Vec::new(),
            jumps: Vec::new(),
            planned,
            outcome: Outcome::Survived,
        }
    }

    /// Returns the rate of the frames (Hz).
    pub(super) fn fps(&self) -> f64 {
        self.robot.control_hz
    }

    /// Returns the robot's body.
    pub(super) fn character(&self) -> &'a Character {
        &self.robot.character
    }

    /// Returns which joints are legs'.
    pub(super) fn legs(&self) -> &[bool] {
        &self.names.legs
    }

    /// Returns reference and robot at a moment.
    pub(super) fn both(&self, moment: &Moment<'_>, kinematics: &mut Kinematics) -> (Snapshot, Snapshot) {
        (self.asked(moment, kinematics), self.done(moment))
    }

    /// Returns the reference of a robot at a moment.
    pub(super) fn asked(&self, moment: &Moment<'_>, kinematics: &mut Kinematics) -> Snapshot {
        self.reference(moment.frame, moment.alignment, moment.ground, kinematics)
    }

    /// Returns the state of a robot at a moment.
    pub(super) fn done(&self, moment: &Moment<'_>) -> Snapshot {
        self.simulated(moment.state, moment.i, moment.ground)
    }

    /// Appends one robot's state, and its reference at that moment.
    pub fn record(&self, rollout: &mut Rollout, moment: &Moment<'_>, kinematics: &mut Kinematics) {
        let &Moment { state, i, .. } = moment;
        let reference = self.asked(moment, kinematics);
        rollout.planned_contact.extend(self.robot.anatomy.soles.values().map(|sole| {
            let lowest = sole.corners.iter().map(|c| kinematics.point(sole.body, c).z).fold(f64::INFINITY, f64::min);
            lowest - reference.ground < SOLE_DOWN
        }));
        rollout.reference.push(reference);
        let simulated = self.done(moment);
        let before = rollout.simulated.last().unwrap_or(&simulated);
        rollout.sole_speed.extend(self.robot.anatomy.soles.values().map(|sole| {
            let at = |s: &Snapshot, corner: &Vec3| s.bodies[sole.body].0 + s.bodies[sole.body].1 * corner;
            let lowest = sole.corners.iter().min_by(|a, b| at(&simulated, a).z.total_cmp(&at(&simulated, b).z));
            let moved = lowest.map_or(0.0, |corner| (at(&simulated, corner) - at(before, corner)).xy().norm());
            (moved * rollout.fps) as f32
        }));
        rollout.simulated.push(simulated);
        let (joints, feet) = (self.names.joints.len(), self.names.feet.len());
        let (torques, squares) = (&state.torque[i * joints..], &state.torque_squared[i * joints..(i + 1) * joints]);
        rollout
            .heat
            .extend(squares.iter().zip(&self.continuous_squared).map(|(square, rated)| square / rated.max(1e-9)));
        rollout.torque_share.extend(torques.iter().zip(&self.torque_max).map(|(t, max)| t / max.max(1e-9)));
        rollout.foot_force.extend(state.foot_force[i * feet..(i + 1) * feet].iter().map(|f| f / self.weight));
    }

    fn reference(&self, frame: usize, alignment: Alignment, ground: &Ground, kinematics: &mut Kinematics) -> Snapshot {
        let (robot, library) = (self.robot, self.library);
        let mut root_position = Vec3::from(alignment.position(library.position_at(frame)).map(f64::from));
        let below = ground.height(root_position.x, root_position.y);
        root_position.z += below;
        let root_orientation = quaternion(&alignment.orientation(library.orientation_at(frame)));
        let joints: Vec<f64> = library.joints_at(frame).iter().map(|q| f64::from(*q)).collect();
        let mut q = robot.default_position();
        let mut scalar = joints.iter();
        for joint in &robot.character.joints {
            let at = joint.q_index;
            if joint.kind == JointKind::Free {
                q[at..at + 3].copy_from_slice(root_position.as_slice());
                q[at + 3..at + 7].copy_from_slice(&lifelike_character::rotation::to_wxyz(&root_orientation));
            } else if joint.is_scalar() {
                q[at] = scalar.next().copied().unwrap_or(q[at]);
            }
        }
        kinematics.update(&robot.character, &q);
        Snapshot {
            root_position,
            root_orientation,
            ground: below + self.lift.get(frame).copied().unwrap_or(0.0),
            joints,
            effectors: robot.effectors.iter().map(|(body, point)| kinematics.point(*body, point)).collect(),
            bodies: kinematics.body_position.iter().copied().zip(kinematics.body_orientation.iter().copied()).collect(),
        }
    }

    fn simulated(&self, state: &BatchState, i: usize, ground: &Ground) -> Snapshot {
        let vector = |values: &[f32]| Vec3::new(values[0].into(), values[1].into(), values[2].into());
        let (joints, bodies) = (self.names.joints.len(), self.names.bodies.len());
        let places = self.robot.effectors.len() + self.robot.key_bodies.len();
        let root_position = vector(&state.root_position[3 * i..]);
        Snapshot {
            root_position,
            ground: ground.height(root_position.x, root_position.y),
            root_orientation: quaternion(&state.root_orientation[4 * i..]),
            joints: state.joint_position[i * joints..(i + 1) * joints].iter().map(|q| f64::from(*q)).collect(),
            effectors: (0..self.robot.effectors.len())
                .map(|p| vector(&state.site_position[3 * (i * places + p)..]))
                .collect(),
            bodies: (i * bodies..(i + 1) * bodies)
                .map(|b| (vector(&state.body_position[3 * b..]), quaternion(&state.body_orientation[4 * b..])))
                .collect(),
        }
    }
}

/// A quaternion that is no rotation (a diverged environment) is taken as upright; its position tells that it diverged.
fn quaternion(wxyz: &[f32]) -> Quat {
    from_wxyz([wxyz[0].into(), wxyz[1].into(), wxyz[2].into(), wxyz[3].into()]).unwrap_or_else(Quat::identity)
}
