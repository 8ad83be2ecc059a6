//! The part of an augmentation that is learned or made by hand: a correction of simulated states.

use lifelike_robot::Robot;

use crate::simulation::Drive;

/// A correction Δs of simulated states towards measured ones (thesis chapter 2). It follows from each environment's
/// state, constraint forces and reference at this step, and from its own records of the steps before.
pub trait StateCorrection: Send {
    /// Returns its name: saved states carry it.
    fn name(&self) -> &str;

    /// Returns how much it looks back on.
    fn history(&self, robot: &Robot) -> HistorySize;

    /// Returns true when it reads constraint wrenches, which cost about another physics step.
    fn needs_wrenches(&self) -> bool {
        true
    }

    /// Corrects one step of some environments. `corrected` comes as the simulated state, `record` as zeros.
    ///
    /// All environments come together so that a network can take them as one batch, but each result must depend on its own
    /// environment alone: which others come along changes from step to step.
    fn correct(&mut self, environments: &mut [CorrectionStep<'_>]);
}

/// Records that a correction looks back on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HistorySize {
    /// Greatest number of steps K.
    pub steps: usize,
    /// Numbers of one step's record.
    pub width: usize,
}

/// One environment at one step.
#[derive(Debug)]
pub struct CorrectionStep<'a> {
    /// State s(t) of the simulation, which no correction changes.
    pub simulated: EnvironmentState<'a>,
    /// Commands r(t) that led to it, `[J]`.
    pub drive: Drive<'a>,
    /// Constraint forces f_C(t); empty where the correction does not need them.
    pub wrenches: EnvironmentWrenches<'a>,
    /// Records of the steps before.
    pub history: History<'a>,
    /// State s(t) + Δs(t) to be reported.
    pub corrected: CorrectedState<'a>,
    /// Record of this step, to be found in the history from the next step on.
    pub record: &'a mut [f32],
}

/// One environment's rows of [`crate::BatchState`].
#[derive(Debug, Clone, Copy)]
pub struct EnvironmentState<'a> {
    /// Root position, `[3]` (m, world).
    pub root_position: &'a [f32],
    /// Root orientation, `[4]` (wxyz).
    pub root_orientation: &'a [f32],
    /// Root linear velocity, `[3]` (m/s, world).
    pub linear_velocity_w: &'a [f32],
    /// Root angular velocity, `[3]` (rad/s, world).
    pub angular_velocity_w: &'a [f32],
    /// Joint positions, `[J]` (rad).
    pub joint_position: &'a [f32],
    /// Joint velocities, `[J]` (rad/s).
    pub joint_velocity: &'a [f32],
    /// Torques of the actuators, `[J]` (N m).
    pub torque: &'a [f32],
    /// Positions of the body frames, `[B, 3]` (m, world).
    pub body_position: &'a [f32],
    /// Orientations of the body frames, `[B, 4]` (wxyz).
    pub body_orientation: &'a [f32],
}

/// One environment's rows to be corrected. The quaternion need not be of unit length. Bodies and sites follow by forward
/// kinematics, so the state stays one that the robot can be in.
#[derive(Debug)]
pub struct CorrectedState<'a> {
    /// Root position, `[3]` (m, world).
    pub root_position: &'a mut [f32],
    /// Root orientation, `[4]` (wxyz).
    pub root_orientation: &'a mut [f32],
    /// Root linear velocity, `[3]` (m/s, world).
    pub linear_velocity_w: &'a mut [f32],
    /// Root angular velocity, `[3]` (rad/s, world).
    pub angular_velocity_w: &'a mut [f32],
    /// Joint positions, `[J]` (rad).
    pub joint_position: &'a mut [f32],
    /// Joint velocities, `[J]` (rad/s).
    pub joint_velocity: &'a mut [f32],
}

/// One environment's rows of [`crate::ConstraintWrenches`].
#[derive(Debug, Clone, Copy)]
pub struct EnvironmentWrenches<'a> {
    /// Wrenches of parents on children, `[B, 6]`.
    pub joint: &'a [f32],
    /// Wrenches of all joints of a body on it, `[B, 6]`: f_C.
    pub constraint: &'a [f32],
    /// Wrenches of contacts, `[B, 6]`.
    pub contact: &'a [f32],
    /// Loads of the actuators, `[J]`.
    pub joint_load: &'a [f32],
}

/// Records of one environment's steps since its reset, the latest K of them.
#[derive(Debug, Clone, Copy)]
pub struct History<'a> {
    pub(super) records: &'a [f32],
    pub(super) width: usize,
}

impl<'a> History<'a> {
    /// Returns the records, the oldest first; none right after a reset.
    pub fn records(&self) -> impl DoubleEndedIterator<Item = &'a [f32]> + ExactSizeIterator {
        self.records.chunks_exact(self.width.max(1))
    }

    /// Returns the record of the step before.
    pub fn last(&self) -> Option<&'a [f32]> {
        self.records().next_back()
    }
}
