//! A simulation whose reported states are corrected towards a real robot's: simulation augmentation (thesis chapter 2).
//!
//! The main path: [`Augmented`] steps any [`Simulation`] and reads its constraint wrenches. It passes both, with each
//! environment's history, to a [`StateCorrection`] and reports the result as its own [`BatchState`].
//!
//! # Why nothing is fed back into the simulation
//! In the thesis the augmentation is a residual on a freely running simulation: Δs(t) is added to the simulated state
//! "at every time step" (2.2). The network is trained on Δs(t) = measured − simulated at the same instant (eq. 2.2), on
//! uncorrected recordings. Its encoder reads "the previous simulation states" and earlier predicted errors (2.4), not
//! corrected states. Δs(t) is thus the error accumulated since the start.
//!
//! Written back, it would be counted twice: the next state would contain the correction and be corrected again. The
//! network would also read states outside of its training data. Constraint forces balance in the simulated state
//! (2.3.1), not in a corrected one. Therefore the simulation never reads a correction, warm starts and contacts are
//! unchanged, and the history alone has memory.

mod correction;
mod history;

use std::sync::Arc;

use lifelike_character::JointKind;
use lifelike_character::kinematics::Kinematics;
use lifelike_robot::Robot;

use crate::batch::{BatchState, EnvironmentParameters, IntegrationState};
use crate::checks;
use crate::constraint_wrenches::ConstraintWrenches;
use crate::error::SimError;
use crate::rows::{self, Rows, Sizes};
use crate::simulation::{Drive, Simulation};
use crate::terrain::Terrain;
pub use correction::{
    CorrectedState, CorrectionStep, EnvironmentState, EnvironmentWrenches, History, HistorySize, StateCorrection,
};
use history::Histories;

/// A simulation that reports corrected states. Everything else (resets, parameters, pushes, wrenches) is the simulation's.
///
/// An environment has diverged when the simulation says so, and also when its correction is not finite. It then stays
/// at the last state that was reported, and is not corrected until it is reset.
///
/// ```
/// use std::sync::Arc;
/// use lifelike_robot::Robot;
/// use lifelike_sim::augmented::{Augmented, CorrectionStep, HistorySize, StateCorrection};
/// use lifelike_sim::{Drive, Simulation, SimulationSpec};
///
/// /// Every joint of the real robot sits 0.01 rad beside the simulated one.
/// struct Offset;
///
/// impl StateCorrection for Offset {
///     fn name(&self) -> &str {
///         "offset"
///     }
///     fn history(&self, _: &Robot) -> HistorySize {
///         HistorySize { steps: 0, width: 0 }
///     }
///     fn needs_wrenches(&self) -> bool {
///         false
///     }
///     fn correct(&mut self, environments: &mut [CorrectionStep<'_>]) {
///         for environment in environments {
///             environment.corrected.joint_position.iter_mut().for_each(|q| *q += 0.01);
///         }
///     }
/// }
///
/// let robot = Arc::new(Robot::load("lima")?);
/// let targets: Vec<f32> = robot.default_pose.iter().map(|&q| q as f32).collect();
/// let mut plain = SimulationSpec::new(1).build(robot.clone())?;
/// let mut augmented = Augmented::new(SimulationSpec::new(1).build(robot)?, Box::new(Offset))?;
/// plain.step(Drive::Targets(&targets))?;
/// augmented.step(Drive::Targets(&targets))?;
/// assert_eq!(augmented.state().joint_position[3], plain.state().joint_position[3] + 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Augmented<S> {
    simulation: S,
    correction: Box<dyn StateCorrection>,
    /// Both names.
    name: String,
    sizes: Sizes,
    histories: Histories,
    state: BatchState,
    /// The state that was reported before: where an environment stays whose correction is not finite.
    previous: BatchState,
    /// Records of the step under way, `[N, width]`.
    records: Vec<f32>,
    record_width: usize,
    kinematics: Kinematics,
    position: Vec<f64>,
    /// Numbers per environment in the simulation's own saved state.
    inner_width: usize,
}

impl<S: Simulation> Augmented<S> {
    /// Corrects what a simulation reports from the next step on.
    ///
    /// # Errors
    /// [`SimError::Model`] for a robot with ball joints: [`BatchState`] does not tell how balls are turned, and bodies follow
    /// root and joints.
    pub fn new(simulation: S, correction: Box<dyn StateCorrection>) -> Result<Self, SimError> {
        let robot = simulation.robot().clone();
        let ball = robot.character.joints.iter().find(|j| j.kind == JointKind::Ball);
        if let Some(joint) = ball {
            let message = format!(
                "expected hinges and slides for a correction in reduced coordinates, got the ball '{}'",
                joint.name
            );
            return Err(SimError::Model { engine: "augmentation", character: robot.name.clone(), message });
        }
        let (n, size) = (simulation.len(), correction.history(&robot));
        Ok(Self {
            name: format!("{}+{}", simulation.engine(), correction.name()),
            sizes: Sizes::of(&robot),
            histories: Histories::new(n, size),
            state: simulation.state().clone(),
            previous: simulation.state().clone(),
            records: vec![0.0; n * size.width],
            record_width: size.width,
            kinematics: Kinematics::new(&robot.character),
            position: robot.character.reference_position(),
            inner_width: simulation.save().width,
            simulation,
            correction,
        })
    }

    /// Returns the simulation, whose own state is the simulated, uncorrected one.
    pub fn simulation(&self) -> &S {
        &self.simulation
    }

    /// Hands the environments that live to the correction.
    fn correct(&mut self, drive: Drive<'_>, wrenches: &ConstraintWrenches) {
        let Sizes { joints, bodies, .. } = self.sizes;
        let simulated = self.simulation.state();
        self.records.fill(0.0);
        let mut records = self.records.chunks_exact_mut(self.record_width.max(1));
        let mut rows = Rows::whole(&mut self.state);
        let mut steps = Vec::with_capacity(simulated.diverged.len());
        for id in 0..simulated.diverged.len() {
            let (out, record) = (rows.take(1, &self.sizes), records.next().unwrap_or_default());
            if out.diverged[0] {
                continue;
            }
            steps.push(CorrectionStep {
                simulated: environment(simulated, id, &self.sizes),
                drive: drive.with_values(row(drive.values(), id, joints)),
                wrenches: EnvironmentWrenches {
                    joint: row(&wrenches.joint, id, 6 * bodies),
                    constraint: row(&wrenches.constraint, id, 6 * bodies),
                    contact: row(&wrenches.contact, id, 6 * bodies),
                    joint_load: row(&wrenches.joint_load, id, joints),
                },
                history: self.histories.get(id),
                corrected: CorrectedState {
                    root_position: out.root_position,
                    root_orientation: out.root_orientation,
                    linear_velocity_w: out.linear_velocity_w,
                    angular_velocity_w: out.angular_velocity_w,
                    joint_position: out.joint_position,
                    joint_velocity: out.joint_velocity,
                },
                record,
            });
        }
        self.correction.correct(&mut steps);
    }

    /// Makes one state of what a correction wrote; false when that is none.
    fn finish(&mut self, id: usize) -> bool {
        let record = row(&self.records, id, self.record_width);
        let simulated = environment(self.simulation.state(), id, &self.sizes);
        let mut out = rows::single(&mut self.state, id, &self.sizes);
        let finite = out.kinematic_columns().iter().all(|column| column.iter().all(|x| x.is_finite()));
        if !finite || !record.iter().all(|x| x.is_finite()) || !normalise(out.root_orientation) {
            return false;
        }
        let moved = *out.root_position != *simulated.root_position
            || *out.root_orientation != *simulated.root_orientation
            || *out.joint_position != *simulated.joint_position;
        let robot = self.simulation.robot();
        if moved {
            follow_joints(robot, &mut self.kinematics, &mut self.position, &mut out);
        }
        self.histories.push(id, record);
        true
    }
}

/// Returns one environment's numbers of a column; none of an empty one.
fn row(values: &[f32], id: usize, width: usize) -> &[f32] {
    values.get(id * width..(id + 1) * width).unwrap_or_default()
}

fn environment<'a>(state: &'a BatchState, id: usize, sizes: &Sizes) -> EnvironmentState<'a> {
    EnvironmentState {
        root_position: row(&state.root_position, id, 3),
        root_orientation: row(&state.root_orientation, id, 4),
        linear_velocity_w: row(&state.linear_velocity_w, id, 3),
        angular_velocity_w: row(&state.angular_velocity_w, id, 3),
        joint_position: row(&state.joint_position, id, sizes.joints),
        joint_velocity: row(&state.joint_velocity, id, sizes.joints),
        torque: row(&state.torque, id, sizes.joints),
        body_position: row(&state.body_position, id, 3 * sizes.bodies),
        body_orientation: row(&state.body_orientation, id, 4 * sizes.bodies),
    }
}

/// Brings a quaternion to unit length; false when it has none. One that is of unit length as far as single precision goes
/// stays as it is, to the last bit.
fn normalise(q: &mut [f32]) -> bool {
    let norm = q.iter().map(|x| x * x).sum::<f32>().sqrt();
    if (norm - 1.0).abs() > 1e-5 {
        q.iter_mut().for_each(|x| *x /= norm);
    }
    norm > 1e-6
}

/// Bodies and sites of corrected root and joints.
fn follow_joints(robot: &Robot, kinematics: &mut Kinematics, position: &mut [f64], out: &mut Rows<'_>) {
    let character = &robot.character;
    if let Some(root) = character.root_joint() {
        let values = out.root_position.iter().chain(&*out.root_orientation);
        position[root.q_index..].iter_mut().zip(values).for_each(|(slot, x)| *slot = f64::from(*x));
    }
    for (joint, x) in character.scalar_joints().zip(&*out.joint_position) {
        position[joint.q_index] = f64::from(*x);
    }
    kinematics.update(character, position);
    let poses = kinematics.body_position.iter().zip(&kinematics.body_orientation).enumerate();
    for (b, (p, q)) in poses.skip(1) {
        out.body_position[3 * b..3 * b + 3].copy_from_slice(&[p.x as f32, p.y as f32, p.z as f32]);
        out.body_orientation[4 * b..4 * b + 4].copy_from_slice(&[q.w, q.i, q.j, q.k].map(|x| x as f32));
    }
    let sites = robot.effectors.iter().chain(&robot.key_bodies);
    for (slot, (body, point)) in out.site_position.chunks_exact_mut(3).zip(sites) {
        let p = kinematics.point(*body, point);
        slot.copy_from_slice(&[p.x as f32, p.y as f32, p.z as f32]);
    }
}

impl<S: Simulation> Simulation for Augmented<S> {
    fn engine(&self) -> &str {
        &self.name
    }

    fn robot(&self) -> &Arc<Robot> {
        self.simulation.robot()
    }

    fn len(&self) -> usize {
        self.simulation.len()
    }

    fn terrain(&self) -> Option<&Arc<Terrain>> {
        self.simulation.terrain()
    }

    fn state(&self) -> &BatchState {
        &self.state
    }

    /// Puts environments into given states, as the simulation does, and forgets their histories: at the initial step the
    /// error is taken to be zero (thesis 2.4).
    fn reset(&mut self, ids: &[usize], positions: &[f64], velocities: &[f64]) -> Result<(), SimError> {
        self.simulation.reset(ids, positions, velocities)?;
        for &id in ids {
            rows::copy(self.simulation.state(), &mut self.state, id, &self.sizes);
            self.histories.clear(id);
        }
        Ok(())
    }

    fn set_parameters(&mut self, id: usize, parameters: EnvironmentParameters) -> Result<(), SimError> {
        self.simulation.set_parameters(id, parameters)
    }

    fn push(&mut self, id: usize, body: usize, force_w: [f32; 3], torque_w: [f32; 3]) -> Result<(), SimError> {
        self.simulation.push(id, body, force_w, torque_w)
    }

    fn clear_pushes(&mut self, id: usize) {
        self.simulation.clear_pushes(id);
    }

    fn step(&mut self, drive: Drive<'_>) -> Result<(), SimError> {
        self.simulation.step(drive)?;
        let wrenches = match self.correction.needs_wrenches() {
            true => self.simulation.constraint_wrenches(drive)?,
            false => ConstraintWrenches::default(),
        };
        self.previous.clone_from(&self.state);
        for id in 0..self.len() {
            if self.state.diverged[id] || self.simulation.state().diverged[id] {
                let out = &mut rows::single(&mut self.state, id, &self.sizes);
                out.clear_forces();
                out.diverged.fill(true);
            } else {
                rows::copy(self.simulation.state(), &mut self.state, id, &self.sizes);
            }
        }
        self.correct(drive, &wrenches);
        for id in 0..self.len() {
            if !self.state.diverged[id] && !self.finish(id) {
                rows::copy(&self.previous, &mut self.state, id, &self.sizes);
                let out = &mut rows::single(&mut self.state, id, &self.sizes);
                out.clear_forces();
                out.diverged.fill(true);
            }
        }
        Ok(())
    }

    fn constraint_wrenches(&mut self, drive: Drive<'_>) -> Result<ConstraintWrenches, SimError> {
        let mut wrenches = self.simulation.constraint_wrenches(drive)?;
        let Sizes { bodies, joints, .. } = self.sizes;
        for (id, rows) in wrenches.chunks_mut(1, bodies, joints).into_iter().enumerate() {
            if self.state.diverged[id] {
                [rows.joint, rows.constraint, rows.contact, rows.joint_load].into_iter().for_each(|x| x.fill(0.0));
            }
        }
        Ok(wrenches)
    }

    fn save(&self) -> IntegrationState {
        let inner = self.simulation.save();
        let mut state = self.state.clone();
        let mut values = Vec::new();
        for id in 0..self.len() {
            values.extend(&inner.values[id * inner.width..(id + 1) * inner.width]);
            let mut reported = rows::single(&mut state, id, &self.sizes);
            for column in reported.kinematic_columns() {
                values.extend(column.iter().map(|x| f64::from(*x)));
            }
            values.push(f64::from(u8::from(reported.diverged[0])));
            self.histories.save(id, &mut values);
        }
        IntegrationState { engine: self.name.clone(), width: self.width(), values, parameters: inner.parameters }
    }

    fn restore(&mut self, state: &IntegrationState) -> Result<(), SimError> {
        checks::saved(state, &self.name, self.len(), self.width())?;
        let inner = state.values.chunks_exact(state.width).flat_map(|row| &row[..self.inner_width]).copied();
        self.simulation.restore(&IntegrationState {
            engine: self.simulation.engine().to_string(),
            width: self.inner_width,
            values: inner.collect(),
            parameters: state.parameters.clone(),
        })?;
        self.state.clone_from(self.simulation.state());
        for (id, values) in state.values.chunks_exact(state.width).enumerate() {
            let mut values = &values[self.inner_width..];
            let mut reported = rows::single(&mut self.state, id, &self.sizes);
            for column in reported.kinematic_columns() {
                let (own, rest) = values.split_at(column.len());
                column.iter_mut().zip(own).for_each(|(slot, x)| *slot = *x as f32);
                values = rest;
            }
            reported.diverged.fill(values[0] != 0.0);
            self.histories.load(id, &values[1..]);
        }
        Ok(())
    }
}

impl<S> Augmented<S> {
    /// Numbers of one environment in a saved state.
    fn width(&self) -> usize {
        let Sizes { joints, sites, bodies, .. } = self.sizes;
        let reported = 13 + 2 * joints + 3 * sites + 7 * bodies;
        self.inner_width + reported + 1 + self.histories.saved_width()
    }
}
