//! Our own engine: MuJoCo's model of the dynamics, many environments at once on SIMD vectors, nothing but Rust.
//!
//! The main path: [`tree`] (what of a robot is the same everywhere) → [`block`] (W environments and their physics step:
//! actuators, [`rigid_body`], [`constraints`], integration) → [`LifelikeSimulation`] (all blocks, on all cores). Numbers are
//! [`lane`]s, one environment each; [`spatial`] is their algebra.
//!
//! A block's result is a function of its own numbers, lane by lane. So results are bit for bit the same for any number of
//! threads and any place in the batch, and one environment never affects another.
//!
//! The model: trees of free, ball, hinge and slide joints with armature, damping, springs, dry friction and limits;
//! the actuator law of `robot::actuator` at every substep; spheres, capsules and boxes that touch level or uneven ground and
//! each other, with pyramids of friction. [`unsupported`] lists what of a robot is left out.

mod block;
mod box_collision;
mod collision;
mod command;
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

use std::sync::Arc;

use lifelike_character::{Joint, JointKind};
use lifelike_robot::Robot;

use crate::batch::{BatchState, EnvironmentParameters};
use crate::batched::{Batched, Engine};
use crate::checks;
use crate::constraint_wrenches::ConstraintWrenches;
use crate::error::SimError;
use crate::rows::{self, Rows, Sizes};
use crate::simulation::{Drive, Simulation};
use crate::terrain::Terrain;
use crate::workers::Workers;
use block::{Block, Model, Workspace};
use constraint_wrenches::BodyWrenches;
use invweight::invweight;
use lane::{Lane, Scalar};
use outputs::{write_forces, write_state};
use profiler::Profiler;

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

/// Names the joint of a dof that has nothing of its own to move.
fn massless(robot: &Robot, dof: usize) -> String {
    let joint = robot.character.joints.iter().find(|j| (j.v_index..j.v_index + j.kind.nv()).contains(&dof));
    format!("joint '{}' moves no mass that other joints do not move alike", joint.map_or("", |j| j.name.as_str()))
}

/// Returns the number of pairs of a robot's own geoms that may collide.
pub fn self_contacts(robot: &Robot) -> usize {
    shapes::collision_pairs(&robot.character).len()
}

/// N environments of one robot, `W` to a vector.
pub type LaneSimulation<T, const W: usize> = Batched<LaneEngine<T, W>>;

/// Our engine without the bookkeeping around it: see [`LaneSimulation`].
pub struct LaneEngine<T: Scalar, const W: usize> {
    robot: Arc<Robot>,
    sizes: Sizes,
    model: Model<T, W>,
    reference: Vec<f64>,
    blocks: Vec<Block<T, W>>,
    workers: Workers<Workspace<T, W>>,
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
        let engine = LaneEngine::new(robot.clone(), environments, threads)?;
        Ok(Self::with_engine(robot, environments, engine))
    }

    /// Returns the memory of each environment: state, parameters, forces and outputs (bytes).
    pub fn bytes_per_environment(&self) -> usize {
        let Sizes { joints, sites, bodies, feet, .. } = self.sizes;
        let outputs = 4 * (13 + 5 * joints + 3 * sites + 7 * bodies + feet) + 1;
        self.engine.blocks.first().map_or(0, Block::bytes) / W + outputs
    }

    /// Sets another number of visits of all constraint rows per physics step: more are nearer to MuJoCo's converged forces.
    #[must_use]
    pub fn with_iterations(mut self, iterations: usize) -> Self {
        self.engine.model.iterations = iterations;
        self
    }

    /// Puts uneven ground in place of the level one.
    #[must_use]
    pub fn with_terrain(mut self, terrain: Arc<Terrain>) -> Self {
        self.engine.model.terrain = Some(terrain);
        self
    }

    /// Returns the equations of motion in a state under joint forces `applied`, constraints left out: what an oracle is asked
    /// about.
    ///
    /// # Errors
    /// As [`Simulation::reset`].
    pub fn dynamics(&mut self, position: &[f64], velocity: &[f64], applied: &[f64]) -> Result<Dynamics, SimError> {
        self.reset(&[0], position, velocity)?;
        let applied: Vec<Lane<T, W>> = applied.iter().map(|x| Lane::splat_f64(*x)).collect();
        let LaneEngine { model, blocks, workers, .. } = &mut self.engine;
        let workspace = workers.first();
        let acceleration = workspace.unconstrained(model, &blocks[0], &applied);
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

    /// Makes one policy step of the first vector of environments towards targets, its stages told to a profiler; no outputs.
    fn step_profiled(&mut self, targets: &[f32], profiler: &mut impl Profiler) {
        let joints = self.sizes.joints;
        let LaneEngine { model, blocks, workers, .. } = &mut self.engine;
        blocks[0].command.set(Drive::Targets(targets), joints);
        profiler.begin();
        blocks[0].step(model, workers.first(), profiler);
    }
}

impl<T: Scalar, const W: usize> LaneEngine<T, W> {
    fn new(robot: Arc<Robot>, environments: usize, threads: usize) -> Result<Self, SimError> {
        let fail = |message: String| SimError::Model { engine: ENGINE, character: robot.name.clone(), message };
        if let Some(body) = robot.character.bodies.iter().find(|b| b.gravcomp != 0.0) {
            return Err(fail(format!("body '{}' has gravity compensation", body.name)));
        }
        let scalar = |j: &&Joint| matches!(j.kind, JointKind::Hinge | JointKind::Slide);
        if let Some(joint) = robot.character.joints.iter().filter(|j| !scalar(j)).find(|j| j.stiffness != 0.0) {
            return Err(fail(format!("joint '{}': springs are for hinges and slides", joint.name)));
        }
        let model = Model::new(&robot)?;
        let workers = Workers::new(threads, || Ok(Workspace::new(&model.tree))).map_err(fail)?;
        let reference = robot.character.reference_position();
        let invweight = invweight(&model.exact, &reference, &model.exact_nominal)
            .map_err(|dof| fail(format!("{}: give the body mass, or the joint armature", massless(&robot, dof))))?;
        let block = Block::new(&model, &invweight);
        let mut engine = Self {
            sizes: Sizes::of(&robot),
            blocks: vec![block; environments.div_ceil(W)],
            workers,
            model,
            reference,
            robot,
        };
        let position = checks::normalised(&engine.robot.default_position(), engine.sizes.root_q);
        // The last block's spare lanes too: they are stepped along.
        for id in 0..engine.blocks.len() * W {
            engine.put(id, &position, &vec![0.0; engine.sizes.nv]);
        }
        Ok(engine)
    }
}

impl<T: Scalar, const W: usize> Engine for LaneEngine<T, W> {
    fn name(&self) -> &'static str {
        ENGINE
    }

    fn terrain(&self) -> Option<&Arc<Terrain>> {
        self.model.terrain.as_ref()
    }

    fn state_width(&self) -> usize {
        let Sizes { nq, nv, bodies, .. } = self.sizes;
        let forces = self.blocks.first().map_or(0, |b| b.forces.len());
        nq + nv + forces + 6 * bodies + 1
    }

    fn put(&mut self, id: usize, position: &[f64], velocity: &[f64]) {
        let (block, lane) = (&mut self.blocks[id / W], id % W);
        for (slot, x) in block.q.iter_mut().zip(position).chain(block.v.iter_mut().zip(velocity)) {
            slot.0[lane] = T::new(*x);
        }
        for force in block.forces.numbers_mut() {
            force.0[lane] = T::default();
        }
        block.diverged[lane] = false;
        self.clear_pushes(id);
    }

    fn set_parameters(&mut self, id: usize, parameters: &EnvironmentParameters) -> Result<(), SimError> {
        let model = &self.model;
        let (block, lane) = (&mut self.blocks[id / W], id % W);
        let mut exact = model.exact_nominal.clone();
        exact.set(0, &model.exact, &model.exact_nominal, parameters);
        let invweight = invweight(&model.exact, &self.reference, &exact).map_err(|dof| SimError::State {
            expected: "factors that leave every joint something to move".into(),
            got: massless(&self.robot, dof),
        })?;
        block.parameters.set(lane, &model.tree, &model.nominal, parameters);
        for (slot, x) in block.invweight.body.iter_mut().zip(&invweight.body) {
            slot.0[lane] = T::new(x.0[0]);
        }
        for (slot, x) in block.invweight.dof.iter_mut().zip(&invweight.dof) {
            slot.0[lane] = T::new(x.0[0]);
        }
        Ok(())
    }

    fn push(&mut self, id: usize, body: usize, force_w: [f32; 3], torque_w: [f32; 3]) {
        let slot = self.blocks[id / W].pushes[body].get_or_insert([Lane::zero(); 6]);
        for (slot, value) in slot.iter_mut().zip(torque_w.iter().chain(&force_w)) {
            slot.0[id % W] = T::new(f64::from(*value));
        }
    }

    fn clear_pushes(&mut self, id: usize) {
        for push in self.blocks[id / W].pushes.iter_mut().flatten() {
            push.iter_mut().for_each(|x| x.0[id % W] = T::default());
        }
    }

    fn observe(&mut self, ids: &[usize], state: &mut BatchState) {
        let (tree, workspace) = (&self.model.tree, self.workers.first());
        let mut blocks: Vec<usize> = ids.iter().map(|id| id / W).collect();
        blocks.dedup();
        let mut at = 0;
        for b in blocks {
            workspace.dynamics.kinematics(tree, &self.blocks[b].q);
            while at < ids.len() && ids[at] / W == b {
                let rows = &mut rows::single(state, ids[at], &self.sizes);
                write_state(&self.model, &self.blocks[b], workspace, ids[at] % W, rows);
                rows.clear_forces();
                rows.diverged.fill(self.blocks[b].diverged[ids[at] % W]);
                at += 1;
            }
        }
    }

    fn step(&mut self, drive: Drive<'_>, state: &mut BatchState) {
        let (model, sizes) = (&self.model, self.sizes);
        let mut rest = Rows::whole(state);
        let chunks = drive.values().chunks(W * sizes.joints);
        let jobs = self.blocks.iter_mut().zip(chunks).map(|(block, values)| {
            let outputs = rest.take(values.len() / sizes.joints, &sizes);
            (block, drive.with_values(values), outputs)
        });
        self.workers.run(jobs.collect(), |workspace, (block, drive, mut outputs)| {
            advance(model, block, workspace, drive, &mut outputs, &sizes);
        });
    }

    fn constraint_wrenches(&mut self, drive: Drive<'_>, out: &mut ConstraintWrenches) {
        let (model, sizes) = (&self.model, self.sizes);
        let chunks = drive.values().chunks(W * sizes.joints);
        let rows = out.chunks_mut(W, sizes.bodies, sizes.joints);
        let jobs = self.blocks.iter().zip(chunks).zip(rows).collect();
        self.workers.run(jobs, |workspace, ((block, values), mut out)| {
            // The solver starts from the forces of the step before and overwrites them.
            let mut block = block.clone();
            block.command.set(drive.with_values(values), sizes.joints);
            let wrenches = BodyWrenches::of(model, &mut block, workspace);
            for lane in 0..values.len() / sizes.joints {
                if !block.diverged[lane] {
                    wrenches.write(model, &workspace.dynamics, lane, &mut out);
                }
            }
        });
    }

    fn save(&self, id: usize, values: &mut Vec<f64>) {
        let (block, lane) = (&self.blocks[id / W], id % W);
        let mut forces = block.forces.clone();
        let numbers = block.q.iter().chain(&block.v).copied().chain(forces.numbers_mut().map(|x| *x));
        values.extend(numbers.map(|x| x.0[lane].to_f64()));
        for push in &block.pushes {
            values.extend(push.unwrap_or([Lane::zero(); 6]).map(|x| x.0[lane].to_f64()));
        }
        values.push(f64::from(u8::from(block.diverged[lane])));
    }

    fn load(&mut self, id: usize, values: &[f64]) {
        let (block, lane) = (&mut self.blocks[id / W], id % W);
        let mut row = values.iter().copied();
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
}

/// Makes one policy step of a block, towards or under the drive of its environments.
fn advance<T: Scalar, const W: usize>(
    model: &Model<T, W>,
    block: &mut Block<T, W>,
    workspace: &mut Workspace<T, W>,
    drive: Drive<'_>,
    outputs: &mut Rows<'_>,
    sizes: &Sizes,
) {
    block.command.set(drive, sizes.joints);
    block.step(model, workspace, &mut ());
    for lane in 0..drive.values().len() / sizes.joints {
        let rows = &mut outputs.take(1, sizes);
        write_state(model, block, workspace, lane, rows);
        if block.diverged[lane] {
            rows.clear_forces();
        } else {
            write_forces(model, block, lane, rows);
        }
        rows.diverged.fill(block.diverged[lane]);
    }
}
