//! MuJoCo 3.17.
//!
//! [`library`] finds and opens the shared library, [`native`] has its types.
//! The main path: [`model`] → [`worker`] → [`wrenches`] (constraint forces, without those of [`closures`]). [`model`]
//! is the text that MuJoCo compiles, with the indices of the robot's parts. A [`worker`] is one thread's model and
//! data: it loads an environment, steps it and stores it.
//!
//! Environments share the workers' `mjData`: each is only its integration state, a compact row of numbers. Thousands of
//! full `mjData` would exceed the cache at every step. A worker's result is a function of the row alone. Results are
//! therefore bit-identical for any number of threads and any place in the batch.

mod closures;
mod fields;
mod library;
mod model;
pub mod native;
mod tuning;
mod worker;
mod wrenches;

use std::sync::Arc;

use lifelike_robot::Robot;

use crate::batch::{BatchState, EnvironmentParameters};
use crate::batched::{Batched, Engine};
use crate::checks;
use crate::constraint_wrenches::ConstraintWrenches;
use crate::error::SimError;
use crate::rows::{self, Rows, Sizes};
use crate::simulation::Drive;
use crate::terrain::Terrain;
use crate::workers::Workers;
pub use library::{VARIABLE, VERSION, find, library};
use model::Layout;
use tuning::Tuning;
use worker::Worker;

/// The name of this engine.
pub const ENGINE: &str = "mujoco";

/// Environments that a thread takes at once: few enough to share the work evenly, many enough not to wait for the queue.
const BLOCK: usize = 8;

/// N environments of one robot in MuJoCo.
pub type MujocoSimulation = Batched<MujocoEngine>;

/// MuJoCo without the bookkeeping around it: see [`MujocoSimulation`].
pub struct MujocoEngine {
    terrain: Option<Arc<Terrain>>,
    layout: Arc<Layout>,
    sizes: Sizes,
    workers: Workers<Worker>,
    /// Integration states, `[N, layout.width]`.
    environments: Vec<f64>,
    /// Fields of the model that an environment's parameters change; `None`: nothing differs.
    tunings: Vec<Option<Tuning>>,
}

impl MujocoSimulation {
    /// `environments` copies of a robot, each in its default pose with the root where the model puts it, stepped by
    /// `threads` threads (0: one per processor).
    ///
    /// MuJoCo gets the character's own text, with a floor added where it has none. Four things are set whatever the
    /// text says: the time step (the robot's), no actuation (the robot's actuator model drives the joints), no
    /// sensors, no automatic reset. Euler takes the place of Runge-Kutta, which would integrate friction explicitly.
    ///
    /// # Errors
    /// [`SimError::EngineUnavailable`] where there is no library. [`SimError::Model`] when the character has no MJCF text,
    /// MuJoCo refuses it, or its bodies and joints are not the character's.
    pub fn new(robot: Arc<Robot>, environments: usize, threads: usize) -> Result<Self, SimError> {
        Self::on(None, robot, environments, threads)
    }

    /// The same on uneven ground, which takes the place of the text's own.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn on(
        terrain: Option<&Terrain>,
        robot: Arc<Robot>,
        environments: usize,
        threads: usize,
    ) -> Result<Self, SimError> {
        let engine = MujocoEngine::new(terrain, &robot, environments, threads)?;
        Ok(Self::with_engine(robot, environments, engine))
    }
}

impl MujocoEngine {
    fn new(terrain: Option<&Terrain>, robot: &Robot, environments: usize, threads: usize) -> Result<Self, SimError> {
        let (model, layout) = model::compile(robot, terrain)?;
        let fail = |message: String| SimError::Model { engine: ENGINE, character: robot.name.clone(), message };
        let (layout, sizes) = (Arc::new(layout), Sizes::of(robot));
        let row = layout.fresh_row(&checks::normalised(&robot.default_position(), sizes.root_q), &vec![0.0; sizes.nv]);
        Ok(Self {
            terrain: terrain.cloned().map(Arc::new),
            workers: Workers::new(threads, || Worker::new(&model, layout.clone())).map_err(fail)?,
            environments: row.repeat(environments),
            tunings: vec![None; environments],
            layout,
            sizes,
        })
    }

    fn row_mut(&mut self, id: usize) -> &mut [f64] {
        let width = self.layout.width;
        &mut self.environments[id * width..(id + 1) * width]
    }
}

impl Engine for MujocoEngine {
    fn name(&self) -> &'static str {
        ENGINE
    }

    fn terrain(&self) -> Option<&Arc<Terrain>> {
        self.terrain.as_ref()
    }

    fn state_width(&self) -> usize {
        self.layout.width
    }

    fn put(&mut self, id: usize, position: &[f64], velocity: &[f64]) {
        let row = self.layout.fresh_row(position, velocity);
        self.row_mut(id).copy_from_slice(&row);
    }

    fn set_parameters(&mut self, id: usize, parameters: &EnvironmentParameters) -> Result<(), SimError> {
        self.tunings[id] = self.workers.first().tuning(parameters);
        Ok(())
    }

    fn push(&mut self, id: usize, body: usize, force_w: [f32; 3], torque_w: [f32; 3]) {
        let start = self.layout.pushes + 6 * body;
        for (slot, value) in self.row_mut(id)[start..start + 6].iter_mut().zip(force_w.iter().chain(&torque_w)) {
            *slot = f64::from(*value);
        }
    }

    fn clear_pushes(&mut self, id: usize) {
        let pushes = self.layout.pushes..self.layout.diverged;
        self.row_mut(id)[pushes].fill(0.0);
    }

    fn observe(&mut self, ids: &[usize], state: &mut BatchState) {
        let width = self.layout.width;
        for &id in ids {
            let row = &self.environments[id * width..(id + 1) * width];
            self.workers.first().observe(row, &mut rows::single(state, id, &self.sizes));
        }
    }

    fn step(&mut self, drive: Drive<'_>, state: &mut BatchState) {
        let (width, sizes) = (self.layout.width, self.sizes);
        let mut rest = Rows::whole(state);
        let environments = self.environments.chunks_mut(BLOCK * width).zip(self.tunings.chunks(BLOCK));
        let values = drive.values().chunks(BLOCK * sizes.joints);
        let jobs = environments
            .zip(values)
            .map(|((rows, tunings), values)| (rows, tunings, values, rest.take(tunings.len(), &sizes)));
        self.workers.run(jobs.collect(), |worker, (rows, tunings, values, mut outputs)| {
            let rows = rows.chunks_exact_mut(width).zip(values.chunks_exact(sizes.joints));
            for ((row, values), tuning) in rows.zip(tunings) {
                worker.step(row, tuning.as_ref(), drive.with_values(values), &mut outputs.take(1, &sizes));
            }
        });
    }

    fn constraint_wrenches(&mut self, drive: Drive<'_>, out: &mut ConstraintWrenches) {
        let sizes = self.sizes;
        let environments = self.environments.chunks(self.layout.width).zip(&self.tunings);
        let values = drive.values().chunks(sizes.joints);
        let jobs = environments.zip(values).zip(out.chunks_mut(1, sizes.bodies, sizes.joints));
        self.workers.run(jobs.collect(), |worker, (((row, tuning), values), mut out)| {
            worker.constraint_wrenches(row, tuning.as_ref(), drive.with_values(values), &mut out);
        });
    }

    fn save(&self, id: usize, values: &mut Vec<f64>) {
        let width = self.layout.width;
        values.extend(&self.environments[id * width..(id + 1) * width]);
    }

    fn load(&mut self, id: usize, values: &[f64]) {
        self.row_mut(id).copy_from_slice(values);
    }
}
