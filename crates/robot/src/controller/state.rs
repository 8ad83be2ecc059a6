//! Memory of one robot's run of a controller.

use lifelike_character::{JointKind, Kinematics};

use super::Controller;
use super::policy::PolicyWorkspace;
use super::prior::PriorScratch;
use crate::action::ActionSpec;
use crate::observation::{MeasuredState, Memory};
use crate::reference::Alignment;
use crate::robot::Robot;

/// State of a run that decides its next step: all that has to be saved to continue it.
#[derive(Debug, Clone, PartialEq)]
pub struct History {
    /// Last output of the policy, clamped, `[J]`.
    pub last: Vec<f32>,
    /// The one before, `[J]`.
    pub before: Vec<f32>,
    /// Offsets of the joints' encoders, `[J]` (rad): added to measured positions, taken from targets.
    pub joint_offset: Vec<f32>,
    /// Place of the reference's world in the robot's.
    pub alignment: Alignment,
    /// Earlier observations, where the policy sees them.
    pub memory: Memory,
    /// An episode was begun.
    pub begun: bool,
}

impl History {
    /// Of a robot with this many joints, before its first episode.
    pub fn new(joints: usize) -> Self {
        Self {
            last: vec![0.0; joints],
            before: vec![0.0; joints],
            joint_offset: vec![0.0; joints],
            alignment: Alignment::default(),
            memory: Memory::default(),
            begun: false,
        }
    }

    /// Takes an output as the last action, after which a step is over. An output that is no number says nothing: it counts as zero.
    pub(super) fn remember(&mut self, spec: ActionSpec, output: &[f32]) {
        std::mem::swap(&mut self.last, &mut self.before);
        for (last, y) in self.last.iter_mut().zip(output) {
            *last = if y.is_finite() { spec.clamp_output(*y) } else { 0.0 };
        }
        self.memory.advance();
    }
}

/// Memory of one robot's run: its history, and buffers that spare allocations.
#[derive(Debug, Clone)]
pub struct ControllerState {
    /// State that decides the next step.
    pub history: History,
    pub(super) scratch: ObservationScratch,
    pub(super) policy: PolicyWorkspace,
    pub(super) observation: Vec<f32>,
    pub(super) outputs: Vec<f32>,
}

impl ControllerState {
    /// Before the first step.
    pub fn new(controller: &Controller) -> Self {
        let joints = controller.robot().joints();
        Self {
            history: History::new(joints),
            scratch: ObservationScratch::new(controller),
            policy: PolicyWorkspace::live(),
            observation: vec![0.0; controller.observation().size()],
            outputs: vec![0.0; joints],
        }
    }

    /// The last observation, normalised and clipped, `[O]`.
    pub fn observation(&self) -> &[f32] {
        &self.observation
    }
}

/// Buffers for what an observation is computed from: encoder and kinematics.
#[derive(Debug, Clone)]
pub struct ObservationScratch {
    pub(super) prior: PriorScratch,
    pub(super) key_bodies: KeyBodies,
}

impl ObservationScratch {
    /// For observations of a controller.
    pub fn new(controller: &Controller) -> Self {
        Self { prior: PriorScratch::new(controller.prior()), key_bodies: KeyBodies::new(controller.robot()) }
    }
}

/// Forward kinematics of the key bodies.
#[derive(Debug, Clone)]
pub(super) struct KeyBodies {
    kinematics: Kinematics,
    position: Vec<f64>,
    places: Vec<f32>,
}

impl KeyBodies {
    fn new(robot: &Robot) -> Self {
        Self {
            kinematics: Kinematics::new(&robot.character),
            position: robot.default_position(),
            places: vec![0.0; 3 * robot.key_bodies.len()],
        }
    }

    /// The key bodies of a measured pose, `[K, 3]` (m, world; about the origin where the root's position is unknown).
    pub(super) fn places(&mut self, robot: &Robot, measured: &MeasuredState<'_>, offset: &[f32]) -> &[f32] {
        let root = measured.root_position.unwrap_or_default();
        let mut joints = measured.joint_position.iter().zip(offset).map(|(q, offset)| f64::from(q + offset));
        for joint in &robot.character.joints {
            let at = joint.q_index;
            if joint.kind == JointKind::Free {
                self.position[at..at + 3].copy_from_slice(&root.map(f64::from));
                self.position[at + 3..at + 7].copy_from_slice(&measured.root_orientation.map(f64::from));
            } else if joint.is_scalar() {
                self.position[at] = joints.next().unwrap_or(self.position[at]);
            }
        }
        self.kinematics.update(&robot.character, &self.position);
        for ((body, point), place) in robot.key_bodies.iter().zip(self.places.as_chunks_mut::<3>().0) {
            *place = self.kinematics.point(*body, point).map(|x| x as f32).into();
        }
        &self.places
    }
}
