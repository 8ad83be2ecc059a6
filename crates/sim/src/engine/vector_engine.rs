//! All environments of a robot, as many to a vector as its lanes are, on all cores.

use std::sync::Arc;

use lifelike_character::{Joint, JointKind};
use lifelike_robot::Robot;

use super::block::{Block, Model, Workspace};
use super::constraint_wrenches::BodyWrenches;
use super::invweight::invweight;
use super::lanes::{Lanes, Scalar};
use super::profiler::Profiler;
use super::{Dynamics, ENGINE};
use crate::batch::{BatchState, EnvironmentParameters};
use crate::batched::Engine;
use crate::checks;
use crate::constraint_wrenches::ConstraintWrenches;
use crate::error::SimError;
use crate::rows::{self, Rows, Sizes};
use crate::simulation::Drive;
use crate::terrain::Terrain;
use crate::workers::Workers;

/// Methods of our engine besides [`Engine`], whatever its vectors are.
pub trait AnyVectors: Engine {
    /// Environments to a vector.
    fn lanes(&self) -> usize;
    /// Memory of each environment (bytes), its outputs left out.
    fn bytes_per_environment(&self) -> usize;
    /// Sets the visits of all constraint rows per physics step.
    fn set_iterations(&mut self, iterations: usize);
    /// Puts uneven ground in place of the level one.
    fn set_terrain(&mut self, terrain: Arc<Terrain>);
    /// The equations of motion of the first environment in its present state, constraints left out.
    fn dynamics(&mut self, applied: &[f64]) -> Dynamics;
    /// Makes one policy step of the first vector of environments towards targets, its stages told to a profiler; no outputs.
    fn step_profiled(&mut self, targets: &[f32], profiler: &mut dyn Profiler);
}

/// Our engine without the bookkeeping around it.
pub struct VectorEngine<V: Lanes> {
    robot: Arc<Robot>,
    sizes: Sizes,
    model: Model<V>,
    reference: Vec<f64>,
    blocks: Vec<Block<V>>,
    workers: Workers<Workspace<V>>,
}

/// Names the joint of a dof that has nothing of its own to move.
fn massless(robot: &Robot, dof: usize) -> String {
    let joint = robot.character.joints.iter().find(|j| (j.v_index..j.v_index + j.kind.nv()).contains(&dof));
    format!("joint '{}' moves no mass that other joints do not move alike", joint.map_or("", |j| j.name.as_str()))
}

impl<V: Lanes> VectorEngine<V> {
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
        let workers = Workers::new(threads, || Ok(Workspace::new(&model.tree))).map_err(fail)?;
        let reference = robot.character.reference_position();
        let invweight = invweight(&model.exact, &reference, &model.exact_nominal)
            .map_err(|dof| fail(format!("{}: give the body mass, or the joint armature", massless(&robot, dof))))?;
        let block = Block::new(&model, &invweight);
        let mut engine = Self {
            sizes: Sizes::of(&robot),
            blocks: vec![block; environments.div_ceil(V::LANES)],
            workers,
            model,
            reference,
            robot,
        };
        let position = checks::normalised(&engine.robot.default_position(), engine.sizes.root_q);
        // The last block's spare lanes too: they are stepped along.
        for id in 0..engine.blocks.len() * V::LANES {
            engine.put(id, &position, &vec![0.0; engine.sizes.nv]);
        }
        Ok(engine)
    }
}

impl<V: Lanes> AnyVectors for VectorEngine<V> {
    fn lanes(&self) -> usize {
        V::LANES
    }

    fn bytes_per_environment(&self) -> usize {
        self.blocks.first().map_or(0, Block::bytes) / V::LANES
    }

    fn set_iterations(&mut self, iterations: usize) {
        self.model.iterations = iterations;
    }

    fn set_terrain(&mut self, terrain: Arc<Terrain>) {
        self.model.terrain = Some(terrain);
    }

    fn dynamics(&mut self, applied: &[f64]) -> Dynamics {
        let applied: Vec<V> = applied.iter().map(|x| V::splat_f64(*x)).collect();
        let Self { model, blocks, workers, .. } = self;
        let workspace = workers.first();
        let acceleration = workspace.unconstrained(model, &blocks[0], &applied);
        let nv = model.tree.nv;
        let mut mass = vec![0.0; nv * nv];
        for (d, dof) in model.tree.dofs.iter().enumerate() {
            for (k, j) in dof.chain.iter().enumerate() {
                let value = workspace.dynamics.mass[dof.row + k].lane(0).to_f64();
                (mass[d * nv + j], mass[j * nv + d]) = (value, value);
            }
        }
        let first = |numbers: &[V]| numbers.iter().map(|x| x.lane(0).to_f64()).collect();
        Dynamics { mass, bias: first(&workspace.dynamics.bias), acceleration: first(&acceleration) }
    }

    fn step_profiled(&mut self, targets: &[f32], profiler: &mut dyn Profiler) {
        let Self { model, blocks, workers, sizes, .. } = self;
        blocks[0].command.set(Drive::Targets(targets), sizes.joints);
        profiler.begin();
        blocks[0].step(model, workers.first(), profiler);
    }
}

impl<V: Lanes> Engine for VectorEngine<V> {
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
        let (block, lane) = (&mut self.blocks[id / V::LANES], id % V::LANES);
        for (slot, x) in block.q.iter_mut().zip(position).chain(block.v.iter_mut().zip(velocity)) {
            slot.set_lane(lane, Scalar::new(*x));
        }
        for force in block.forces.numbers_mut() {
            force.set_lane(lane, Scalar::new(0.0));
        }
        block.diverged[lane] = false;
        self.clear_pushes(id);
    }

    fn set_parameters(&mut self, id: usize, parameters: &EnvironmentParameters) -> Result<(), SimError> {
        let model = &self.model;
        let (block, lane) = (&mut self.blocks[id / V::LANES], id % V::LANES);
        let mut exact = model.exact_nominal.clone();
        exact.set(0, &model.exact, &model.exact_nominal, parameters);
        let invweight = invweight(&model.exact, &self.reference, &exact).map_err(|dof| SimError::State {
            expected: "factors that leave every joint something to move".into(),
            got: massless(&self.robot, dof),
        })?;
        block.parameters.set(lane, &model.tree, &model.nominal, parameters);
        let own = &mut block.invweight;
        for (slots, numbers) in
            [(&mut own.body, &invweight.body), (&mut own.turn, &invweight.turn), (&mut own.dof, &invweight.dof)]
        {
            for (slot, x) in slots.iter_mut().zip(numbers) {
                slot.set_lane(lane, Scalar::new(*x));
            }
        }
        Ok(())
    }

    fn push(&mut self, id: usize, body: usize, force_w: [f32; 3], torque_w: [f32; 3]) {
        let slot = self.blocks[id / V::LANES].pushes[body].get_or_insert([V::zero(); 6]);
        for (slot, value) in slot.iter_mut().zip(torque_w.iter().chain(&force_w)) {
            slot.set_lane(id % V::LANES, Scalar::new(f64::from(*value)));
        }
    }

    fn clear_pushes(&mut self, id: usize) {
        for push in self.blocks[id / V::LANES].pushes.iter_mut().flatten() {
            push.iter_mut().for_each(|x| x.set_lane(id % V::LANES, Scalar::new(0.0)));
        }
    }

    fn observe(&mut self, ids: &[usize], state: &mut BatchState) {
        let (tree, workspace) = (&self.model.tree, self.workers.first());
        let mut blocks: Vec<usize> = ids.iter().map(|id| id / V::LANES).collect();
        blocks.dedup();
        let mut at = 0;
        for b in blocks {
            workspace.dynamics.kinematics(tree, &self.blocks[b].q);
            workspace.outputs.compute(&self.model, &self.blocks[b], &workspace.dynamics, &self.sizes);
            while at < ids.len() && ids[at] / V::LANES == b {
                let rows = &mut rows::single(state, ids[at], &self.sizes);
                workspace.outputs.write(ids[at] % V::LANES, rows);
                rows.clear_forces();
                rows.diverged.fill(self.blocks[b].diverged[ids[at] % V::LANES]);
                at += 1;
            }
        }
    }

    fn step(&mut self, drive: Drive<'_>, state: &mut BatchState) {
        let (model, sizes) = (&self.model, self.sizes);
        let mut rest = Rows::whole(state);
        let chunks = drive.values().chunks(V::LANES * sizes.joints);
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
        let chunks = drive.values().chunks(V::LANES * sizes.joints);
        let rows = out.chunks_mut(V::LANES, sizes.bodies, sizes.joints);
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
        let (block, lane) = (&self.blocks[id / V::LANES], id % V::LANES);
        let mut forces = block.forces.clone();
        let numbers = block.q.iter().chain(&block.v).copied().chain(forces.numbers_mut().map(|x| *x));
        values.extend(numbers.map(|x| x.lane(lane).to_f64()));
        for push in &block.pushes {
            values.extend(push.unwrap_or([V::zero(); 6]).map(|x| x.lane(lane).to_f64()));
        }
        values.push(f64::from(u8::from(block.diverged[lane])));
    }

    fn load(&mut self, id: usize, values: &[f64]) {
        let (block, lane) = (&mut self.blocks[id / V::LANES], id % V::LANES);
        let mut row = values.iter().copied();
        let slots = block.q.iter_mut().chain(&mut block.v).chain(block.forces.numbers_mut());
        for (slot, value) in slots.zip(&mut row) {
            slot.set_lane(lane, Scalar::new(value));
        }
        for push in &mut block.pushes {
            let values: [f64; 6] = std::array::from_fn(|_| row.next().unwrap_or(0.0));
            if push.is_some() || values.iter().any(|x| *x != 0.0) {
                let lanes = push.get_or_insert([V::zero(); 6]);
                lanes.iter_mut().zip(values).for_each(|(x, value)| x.set_lane(lane, Scalar::new(value)));
            }
        }
        block.diverged[lane] = row.next().is_some_and(|x| x != 0.0);
    }
}

/// Makes one policy step of a block, towards or under the drive of its environments.
fn advance<V: Lanes>(
    model: &Model<V>,
    block: &mut Block<V>,
    workspace: &mut Workspace<V>,
    drive: Drive<'_>,
    outputs: &mut Rows<'_>,
    sizes: &Sizes,
) {
    block.command.set(drive, sizes.joints);
    block.step(model, workspace, &mut ());
    workspace.outputs.compute(model, block, &workspace.dynamics, sizes);
    workspace.outputs.write(0, outputs);
    outputs.diverged.copy_from_slice(&block.diverged[..outputs.diverged.len()]);
    if outputs.diverged.contains(&true) {
        for diverged in &block.diverged[..outputs.diverged.len()] {
            let mut row = outputs.take(1, sizes);
            if *diverged {
                row.clear_forces();
            }
        }
    }
}
