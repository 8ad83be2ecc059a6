//! Our own engine: MuJoCo's model of the dynamics, many environments at once on SIMD vectors, nothing but Rust.
//!
//! The main path: [`tree`] (what of a robot is the same everywhere) → [`block`] (W environments and their physics step:
//! actuators, [`dynamics`], [`constraints`], integration) → [`LifelikeSimulation`] (all blocks, on all cores). Numbers are
//! [`lane`]s, one environment each; [`spatial`] is their algebra.
//!
//! A block's result is a function of its own numbers, lane by lane. So results are bit for bit the same for any number of
//! threads and any place in the batch, and what one environment does never reaches another.
//!
//! What is modelled: trees of free, ball, hinge and slide joints with armature, damping, springs, dry friction and limits;
//! the actuator law of `robot::actuator` at every substep; spheres, capsules and boxes that touch level or uneven ground and
//! each other, with pyramids of friction. [`unsupported`] lists what of a robot is left out.

mod block;
mod box_collision;
mod collision;
mod constraint_wrenches;
mod constraints;
mod contact;
mod dof_chain;
mod factors;
mod invweight;
pub mod lane;
mod model_parameters;
mod outputs;
pub mod profile;
mod profiler;
mod rigid_body;
mod shapes;
mod solver_context;
mod spatial;
mod surface;
mod tree;
mod unsupported;

use std::sync::{Arc, Mutex, PoisonError};

use lifelike_character::{Joint, JointKind};
use lifelike_robot::Robot;
use rayon::prelude::*;

use crate::batch::{BatchState, Drive, EnvironmentParameters, IntegrationState, Simulation};
use crate::checks::{self, Coordinates};
use crate::error::SimError;
use crate::rows::{self, Rows, Widths};
use crate::terrain::Terrain;
use block::{Block, Model, Workspace};
use constraint_wrenches::BodyWrenches;
use invweight::invweight;
use lane::{Lane, Scalar};
use outputs::{write_forces, write_no_forces, write_state};
use profiler::Profiler;

pub use constraint_wrenches::BodyForces;
#[cfg(feature = "mujoco")]
pub(crate) use surface::{SOLIMP, SOLREF};
pub use unsupported::unsupported;

/// The name of this engine.
pub const ENGINE: &str = "lifelike";

/// Environments that are stepped together: two AVX2 vectors or one of AVX-512. Where a vector waits for its last result the
/// other goes on (`docs/results/engine.md`).
pub const LANES: usize = 16;

/// The engine as it is used: single precision.
pub type LifelikeSimulation = LaneSimulation<f32, LANES>;

/// Says that a dof has nothing of its own to move.
fn massless(robot: &Robot, dof: usize) -> String {
    let joint = robot.character.joints.iter().find(|j| (j.v_index..j.v_index + j.kind.nv()).contains(&dof));
    format!("joint '{}' moves no mass that other joints do not move alike", joint.map_or("", |j| j.name.as_str()))
}

/// Pairs of a robot's own geoms that may touch.
pub fn self_contacts(robot: &Robot) -> usize {
    shapes::collision_pairs(&robot.character).len()
}

/// N environments of one robot, `W` to a vector.
pub struct LaneSimulation<T: Scalar, const W: usize> {
    robot: Arc<Robot>,
    model: Model<T, W>,
    reference: Vec<f64>,
    widths: Widths,
    blocks: Vec<Block<T, W>>,
    workspaces: Vec<Workspace<T, W>>,
    pool: rayon::ThreadPool,
    parameters: Vec<EnvironmentParameters>,
    state: BatchState,
}

/// M a + c = f.
#[derive(Debug, Clone, PartialEq)]
pub struct Dynamics {
    /// Mass matrix M, `[nv, nv]`.
    pub mass: Vec<f64>,
    /// Bias forces c: Coriolis, centrifugal, gravity.
    pub bias: Vec<f64>,
    /// Acceleration a.
    pub acceleration: Vec<f64>,
}

impl<T: Scalar, const W: usize> LaneSimulation<T, W> {
    /// `environments` copies of a robot, each in its default pose with the root where the model puts it, stepped by
    /// `threads` threads (0: one per processor).
    ///
    /// # Errors
    /// [`SimError::Model`] for ground that is not level, gravity compensation, and springs on balls.
    pub fn new(robot: Arc<Robot>, environments: usize, threads: usize) -> Result<Self, SimError> {
        let fail = |message: String| SimError::Model { engine: ENGINE, character: robot.name.clone(), message };
        if let Some(body) = robot.character.bodies.iter().find(|b| b.gravcomp != 0.0) {
            return Err(fail(format!("body '{}' has gravity compensation", body.name)));
        }
        let scalar = |j: &&Joint| matches!(j.kind, JointKind::Hinge | JointKind::Slide);
        if let Some(joint) = robot.character.joints.iter().filter(|j| !scalar(j)).find(|j| j.stiffness != 0.0) {
            return Err(fail(format!("joint '{}': springs are for hinges and slides", joint.name)));
        }
        let model = Model::new(&robot)?;
        let tree = &model.tree;
        let pool = checks::pool(threads).map_err(|e| fail(e.to_string()))?;
        let widths =
            Widths { joints: tree.driven.len(), places: tree.places.len(), bodies: tree.bodies.len(), feet: tree.feet };
        let reference = robot.character.reference_position();
        let weights = invweight(&model.exact, &reference, &model.exact_nominal)
            .map_err(|dof| fail(format!("{}: give the body mass, or the joint armature", massless(&robot, dof))))?;
        let block = Block::new(&model, &weights);
        let mut simulation = Self {
            state: rows::allocate(environments, &widths),
            workspaces: vec![Workspace::new(tree); pool.current_num_threads()],
            blocks: vec![block; environments.div_ceil(W)],
            model,
            parameters: vec![EnvironmentParameters::default(); environments],
            reference,
            widths,
            pool,
            robot,
        };
        let position = simulation.robot.default_position();
        // The last block's spare lanes too: they are stepped along.
        for id in 0..simulation.blocks.len() * W {
            simulation.put(id, &position, &vec![0.0; simulation.model.tree.nv]);
        }
        let ids: Vec<usize> = (0..environments).collect();
        simulation.refresh(&ids);
        Ok(simulation)
    }

    /// Memory of each environment: state, parameters, forces and outputs (bytes).
    pub fn bytes_per_environment(&self) -> usize {
        let Widths { joints, places, bodies, feet } = self.widths;
        let outputs = 4 * (13 + 5 * joints + 3 * places + 7 * bodies + feet) + 1;
        self.blocks.first().map_or(0, Block::bytes) / W + outputs
    }

    /// Another number of visits of all constraint rows per physics step: more are nearer to MuJoCo's converged forces.
    #[must_use]
    pub fn with_iterations(mut self, iterations: usize) -> Self {
        self.model.iterations = iterations;
        self
    }

    /// Uneven ground in place of the level one.
    #[must_use]
    pub fn with_terrain(mut self, terrain: Arc<Terrain>) -> Self {
        self.model.terrain = Some(terrain);
        self
    }

    /// The equations of motion in a state under joint forces `applied`, constraints left out: what an oracle is asked about.
    ///
    /// # Errors
    /// As [`Simulation::reset`].
    pub fn dynamics(&mut self, position: &[f64], velocity: &[f64], applied: &[f64]) -> Result<Dynamics, SimError> {
        self.reset(&[0], position, velocity)?;
        let applied: Vec<Lane<T, W>> = applied.iter().map(|x| Lane::splat_f64(*x)).collect();
        let (model, block, workspace) = (&self.model, &self.blocks[0], &mut self.workspaces[0]);
        let acceleration = workspace.unconstrained(model, block, &applied);
        let nv = model.tree.nv;
        let mut mass = vec![0.0; nv * nv];
        for (d, dof) in model.tree.dofs.iter().enumerate() {
            for (k, j) in dof.chain.iter().enumerate() {
                let value = workspace.dynamics.mass[dof.row + k].0[0].to_f64();
                (mass[d * nv + j], mass[j * nv + d]) = (value, value);
            }
        }
        let first = |lanes: &[Lane<T, W>]| lanes.iter().map(|x| x.0[0].to_f64()).collect();
        Ok(Dynamics { mass, bias: first(&workspace.dynamics.bias), acceleration: first(&acceleration) })
    }

    /// Forces in joints and on bodies in the present state under a drive. As MuJoCo's `mj_rnePostConstraint` after `mj_forward`:
    /// damping is not yet taken implicitly. Nothing changes; diverged environments have none.
    ///
    /// # Errors
    /// [`SimError::Length`] for a drive of another size.
    pub fn body_forces(&mut self, drive: Drive<'_>) -> Result<BodyForces, SimError> {
        let joints = self.widths.joints;
        let numbers = checks::drive(&drive, self.len() * joints)?;
        let targets = matches!(drive, Drive::Targets(_));
        let mut out = BodyForces::default();
        let workspace = &mut self.workspaces[0];
        for (block, numbers) in self.blocks.iter().zip(numbers.chunks(W * joints)) {
            // The solver starts from the forces of the step before and overwrites them.
            let mut block = block.clone();
            command(&mut block, numbers, joints);
            let wrenches = BodyWrenches::of(&self.model, &mut block, workspace, targets);
            for lane in 0..numbers.len() / joints {
                wrenches.write(&workspace.dynamics, block.diverged[lane], lane, &mut out);
            }
        }
        Ok(out)
    }

    /// One policy step of the first vector of environments towards targets, its stages told to a profiler; no outputs.
    fn clocked(&mut self, targets: &[f32], profiler: &mut impl Profiler) {
        let (block, workspace) = (&mut self.blocks[0], &mut self.workspaces[0]);
        command(block, targets, self.widths.joints);
        profiler.begin();
        block.step(&self.model, workspace, true, profiler);
    }

    fn put(&mut self, id: usize, position: &[f64], velocity: &[f64]) {
        let (block, lane) = (&mut self.blocks[id / W], id % W);
        let tree = &self.model.tree;
        for (slot, x) in block.q.iter_mut().zip(&checks::normalised(position, tree.root_q)) {
            slot.0[lane] = T::new(*x);
        }
        for (slot, x) in block.v.iter_mut().zip(velocity) {
            slot.0[lane] = T::new(*x);
        }
        for force in block.forces.numbers_mut() {
            force.0[lane] = T::default();
        }
        block.diverged[lane] = false;
        self.release(id);
    }

    /// Ends all pushes on one environment.
    fn release(&mut self, id: usize) {
        for push in self.blocks[id / W].pushes.iter_mut().flatten() {
            push.iter_mut().for_each(|x| x.0[id % W] = T::default());
        }
    }

    /// Outputs of environments that did not step: poses and velocities; torques and forces are zero.
    fn refresh(&mut self, ids: &[usize]) {
        let (tree, workspace) = (&self.model.tree, &mut self.workspaces[0]);
        let mut blocks: Vec<usize> = ids.iter().map(|id| id / W).collect();
        blocks.dedup();
        let mut at = 0;
        for b in blocks {
            workspace.dynamics.kinematics(tree, &self.blocks[b].q);
            while at < ids.len() && ids[at] / W == b {
                let rows = &mut rows::single(&mut self.state, ids[at], &self.widths);
                write_state(&self.model, &self.blocks[b], workspace, ids[at] % W, rows);
                write_no_forces(rows);
                rows.diverged.fill(self.blocks[b].diverged[ids[at] % W]);
                at += 1;
            }
        }
    }

    /// Numbers of one environment in a saved state.
    fn width(&self) -> usize {
        let tree = &self.model.tree;
        let forces = self.blocks.first().map_or(0, |b| b.forces.len());
        tree.nq + tree.nv + forces + 6 * tree.bodies.len() + 1
    }

    fn tune(&mut self, id: usize) -> Result<(), SimError> {
        let (parameters, model) = (&self.parameters[id], &self.model);
        checks::parameters(parameters, self.widths.bodies, self.widths.joints, self.widths.feet)?;
        let (block, lane) = (&mut self.blocks[id / W], id % W);
        let mut exact = model.exact_nominal.clone();
        exact.set(0, &model.exact, &model.exact_nominal, parameters);
        let weights = invweight(&model.exact, &self.reference, &exact).map_err(|dof| SimError::State {
            expected: "factors that leave every joint something to move".into(),
            got: massless(&self.robot, dof),
        })?;
        block.parameters.set(lane, &model.tree, &model.nominal, parameters);
        for (slot, x) in block.invweight.body.iter_mut().zip(&weights.body) {
            slot.0[lane] = T::new(x.0[0]);
        }
        for (slot, x) in block.invweight.dof.iter_mut().zip(&weights.dof) {
            slot.0[lane] = T::new(x.0[0]);
        }
        Ok(())
    }
}

impl<T: Scalar, const W: usize> Simulation for LaneSimulation<T, W> {
    fn engine(&self) -> &'static str {
        ENGINE
    }

    fn robot(&self) -> &Arc<Robot> {
        &self.robot
    }

    fn len(&self) -> usize {
        self.parameters.len()
    }

    fn terrain(&self) -> Option<&Arc<Terrain>> {
        self.model.terrain.as_ref()
    }

    fn state(&self) -> &BatchState {
        &self.state
    }

    fn reset(&mut self, ids: &[usize], positions: &[f64], velocities: &[f64]) -> Result<(), SimError> {
        let (nq, nv, root) = (self.model.tree.nq, self.model.tree.nv, self.model.tree.root_q);
        checks::reset(ids, self.len(), positions, velocities, Coordinates { nq, nv, root })?;
        for (i, &id) in ids.iter().enumerate() {
            self.put(id, &positions[i * nq..(i + 1) * nq], &velocities[i * nv..(i + 1) * nv]);
        }
        self.refresh(ids);
        Ok(())
    }

    fn set_parameters(&mut self, id: usize, parameters: EnvironmentParameters) -> Result<(), SimError> {
        checks::environment(id, self.len())?;
        let before = std::mem::replace(&mut self.parameters[id], parameters);
        let result = self.tune(id);
        if result.is_err() {
            self.parameters[id] = before;
        }
        result
    }

    fn push(&mut self, id: usize, body: usize, force_w: [f32; 3], torque_w: [f32; 3]) -> Result<(), SimError> {
        checks::environment(id, self.len())?;
        checks::push(body, self.widths.bodies, &force_w, &torque_w)?;
        let slot = self.blocks[id / W].pushes[body].get_or_insert([Lane::zero(); 6]);
        for (slot, value) in slot.iter_mut().zip(torque_w.iter().chain(&force_w)) {
            slot.0[id % W] = T::new(f64::from(*value));
        }
        Ok(())
    }

    fn clear_pushes(&mut self, id: usize) {
        if id < self.len() {
            self.release(id);
        }
    }

    fn step(&mut self, drive: Drive<'_>) -> Result<(), SimError> {
        let joints = self.widths.joints;
        let numbers = checks::drive(&drive, self.len() * joints)?;
        let targets = matches!(drive, Drive::Targets(_));
        let (model, widths) = (&self.model, self.widths);
        let mut rest = Rows::whole(&mut self.state);
        let jobs: Vec<_> = self
            .blocks
            .iter_mut()
            .zip(numbers.chunks(W * joints))
            .map(|(block, numbers)| {
                let outputs = rest.take(numbers.len() / joints, &widths);
                (block, numbers, outputs)
            })
            .collect();
        let queue = Mutex::new(jobs.into_iter());
        let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
        let workspaces = &mut self.workspaces;
        self.pool.install(|| {
            workspaces.par_iter_mut().with_max_len(1).for_each(|workspace| {
                while let Some((block, numbers, mut outputs)) = next() {
                    advance(model, block, workspace, numbers, targets, &mut outputs, &widths);
                }
            });
        });
        Ok(())
    }

    fn save(&self) -> IntegrationState {
        let mut values = Vec::with_capacity(self.len() * self.width());
        for id in 0..self.len() {
            let (block, lane) = (&self.blocks[id / W], id % W);
            let mut forces = block.forces.clone();
            let numbers = block.q.iter().chain(&block.v).copied().chain(forces.numbers_mut().map(|x| *x));
            values.extend(numbers.map(|x| x.0[lane].to_f64()));
            for push in &block.pushes {
                values.extend(push.unwrap_or([Lane::zero(); 6]).map(|x| x.0[lane].to_f64()));
            }
            values.push(f64::from(u8::from(block.diverged[lane])));
        }
        let (width, parameters) = (self.width(), self.parameters.clone());
        IntegrationState { engine: ENGINE.to_string(), width, values, parameters }
    }

    fn restore(&mut self, state: &IntegrationState) -> Result<(), SimError> {
        checks::saved(state, ENGINE, self.len(), self.width())?;
        for parameters in &state.parameters {
            checks::parameters(parameters, self.widths.bodies, self.widths.joints, self.widths.feet)?;
        }
        for (id, parameters) in state.parameters.iter().enumerate() {
            if self.parameters[id] != *parameters {
                self.set_parameters(id, parameters.clone())?;
            }
        }
        for (id, row) in state.values.chunks_exact(state.width).enumerate() {
            let (block, lane) = (&mut self.blocks[id / W], id % W);
            let mut row = row.iter().copied();
            let slots = block.q.iter_mut().chain(&mut block.v).chain(block.forces.numbers_mut());
            for (slot, value) in slots.zip(&mut row) {
                slot.0[lane] = T::new(value);
            }
            for push in &mut block.pushes {
                let values: [f64; 6] = std::array::from_fn(|_| row.next().unwrap_or(0.0));
                if push.is_some() || values.iter().any(|x| *x != 0.0) {
                    let lanes = push.get_or_insert([Lane::zero(); 6]);
                    lanes.iter_mut().zip(values).for_each(|(x, value)| x.0[lane] = T::new(value));
                }
            }
            block.diverged[lane] = row.next().is_some_and(|x| x != 0.0);
        }
        let ids: Vec<usize> = (0..self.len()).collect();
        self.refresh(&ids);
        Ok(())
    }
}

/// Hands the numbers that drive the joints to the lanes.
fn command<T: Scalar, const W: usize>(block: &mut Block<T, W>, numbers: &[f32], joints: usize) {
    for (lane, row) in numbers.chunks_exact(joints).enumerate() {
        for (slot, x) in block.command.iter_mut().zip(row) {
            slot.0[lane] = T::new(f64::from(*x));
        }
    }
}

/// One policy step of one block.
fn advance<T: Scalar, const W: usize>(
    model: &Model<T, W>,
    block: &mut Block<T, W>,
    workspace: &mut Workspace<T, W>,
    numbers: &[f32],
    targets: bool,
    outputs: &mut Rows<'_>,
    widths: &Widths,
) {
    let joints = widths.joints;
    command(block, numbers, joints);
    block.step(model, workspace, targets, &mut ());
    for lane in 0..numbers.len() / joints {
        let rows = &mut outputs.take(1, widths);
        write_state(model, block, workspace, lane, rows);
        if block.diverged[lane] {
            write_no_forces(rows);
        } else {
            write_forces(model, block, lane, rows);
        }
        rows.diverged.fill(block.diverged[lane]);
    }
}
