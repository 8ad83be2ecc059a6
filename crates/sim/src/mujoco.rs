//! MuJoCo 3.17.
//!
//! The main path: [`model`] (the text MuJoCo compiles, and where in it the robot's parts are) → [`worker`] (one thread's
//! model and data: loads an environment, steps it, stores it) → `rows` (which part of the outputs a worker writes).
//!
//! Environments share the workers' `mjData`: each is only its integration state, a compact row of numbers. Thousands of
//! full `mjData` would fall out of the cache at every step, and a row is all there is to save. A worker's result is a
//! function of the row alone, so results are bit for bit the same for any number of threads and any place in the batch.

mod log;
mod model;

mod worker;

use std::sync::{Arc, Mutex, PoisonError};

use lifelike_robot::Robot;

use crate::batch::{BatchState, Drive, EnvironmentParameters, IntegrationState, Simulation};
use crate::checks;
use crate::error::SimError;
use crate::rows::{self, Rows, Widths};
use crate::terrain::Terrain;
use model::Layout;
use worker::{Command, Tuning, Worker};

/// The name of this engine.
pub const ENGINE: &str = "mujoco";

/// Environments that a thread takes at once: few enough to share the work evenly, many enough not to wait for the queue.
const BLOCK: usize = 8;

/// N environments of one robot in MuJoCo.
pub struct MujocoSimulation {
    robot: Arc<Robot>,
    terrain: Option<Arc<Terrain>>,
    layout: Arc<Layout>,
    widths: Widths,
    workers: Vec<Worker>,
    pool: rayon::ThreadPool,
    /// Integration states, `[N, layout.width]`.
    environments: Vec<f64>,
    parameters: Vec<EnvironmentParameters>,
    /// What the parameters mean for the model; `None`: nothing differs.
    tunings: Vec<Option<Tuning>>,
    state: BatchState,
}

impl MujocoSimulation {
    /// `environments` copies of a robot, each in its default pose with the root where the model puts it, stepped by
    /// `threads` threads (0: one per processor).
    ///
    /// MuJoCo gets the character's own text, with a floor added where it has none. Four things are set whatever the text
    /// says: the time step (the robot's), no actuation (the robot's actuator model drives the joints), no sensors, no
    /// automatic reset; and Euler instead of Runge-Kutta, which would integrate friction explicitly.
    ///
    /// # Errors
    /// [`SimError::Model`] when the character has no MJCF text, MuJoCo refuses it, or its bodies and joints are not the
    /// character's.
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
        let (model, layout) = model::compile(&robot, terrain)?;
        let fail = |message: String| SimError::Model { engine: ENGINE, character: robot.name.clone(), message };
        let pool = checks::pool(threads).map_err(|e| fail(e.to_string()))?;
        let layout = Arc::new(layout);
        let mut workers = Vec::new();
        for _ in 0..pool.current_num_threads() {
            workers.push(Worker::new(&model, layout.clone()).map_err(fail)?);
        }
        let widths = Widths {
            joints: layout.joints.len(),
            places: layout.places.len(),
            bodies: robot.character.bodies.len(),
            feet: layout.feet,
        };
        let mut simulation = Self {
            state: rows::allocate(environments, &widths),
            environments: vec![0.0; environments * layout.width],
            parameters: vec![EnvironmentParameters::default(); environments],
            tunings: vec![None; environments],
            robot,
            terrain: terrain.cloned().map(Arc::new),
            layout,
            widths,
            workers,
            pool,
        };
        let position = simulation.robot.default_position();
        let (nq, nv) = (simulation.layout.nq, simulation.layout.nv);
        let mut positions = Vec::with_capacity(environments * nq);
        (0..environments).for_each(|_| positions.extend_from_slice(&position));
        let ids: Vec<usize> = (0..environments).collect();
        simulation.reset(&ids, &positions, &vec![0.0; environments * nv])?;
        Ok(simulation)
    }

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.workers.len()
    }

    /// Writes the outputs of environments that did not step: poses and velocities; torques and forces are zero.
    fn refresh(&mut self, ids: &[usize]) {
        let Some(worker) = self.workers.first_mut() else { return };
        let width = self.layout.width;
        for &id in ids {
            let row = &self.environments[id * width..(id + 1) * width];
            worker.observe(row, &mut rows::single(&mut self.state, id, &self.widths));
        }
    }

    fn tune(&mut self, id: usize) -> Result<(), SimError> {
        let parameters = &self.parameters[id];
        checks::parameters(parameters, self.widths.bodies, self.widths.joints, self.widths.feet)?;
        if let Some(worker) = self.workers.first_mut() {
            self.tunings[id] = worker.tuning(parameters);
        }
        Ok(())
    }
}

impl Simulation for MujocoSimulation {
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
        self.terrain.as_ref()
    }

    fn state(&self) -> &BatchState {
        &self.state
    }

    fn reset(&mut self, ids: &[usize], positions: &[f64], velocities: &[f64]) -> Result<(), SimError> {
        checks::reset(ids, self.len(), positions, velocities, self.layout.coordinates())?;
        let (nq, nv) = (self.layout.nq, self.layout.nv);
        for (i, &id) in ids.iter().enumerate() {
            let row = self.layout.fresh_row(&positions[i * nq..(i + 1) * nq], &velocities[i * nv..(i + 1) * nv]);
            self.environments[id * self.layout.width..(id + 1) * self.layout.width].copy_from_slice(&row);
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
        let start = id * self.layout.width + self.layout.pushes + 6 * body;
        for (slot, value) in self.environments[start..start + 6].iter_mut().zip(force_w.iter().chain(&torque_w)) {
            *slot = f64::from(*value);
        }
        Ok(())
    }

    fn clear_pushes(&mut self, id: usize) {
        if id < self.len() {
            let start = id * self.layout.width;
            self.environments[start + self.layout.pushes..start + self.layout.diverged].fill(0.0);
        }
    }

    fn step(&mut self, drive: Drive<'_>) -> Result<(), SimError> {
        let joints = self.layout.joints.len();
        let numbers = checks::drive(&drive, self.len() * joints)?;
        let (width, widths) = (self.layout.width, self.widths);
        let mut rest = Rows::whole(&mut self.state);
        let blocks: Vec<_> = self
            .environments
            .chunks_mut(BLOCK * width)
            .zip(self.tunings.chunks(BLOCK))
            .zip(numbers.chunks(BLOCK * joints))
            .map(|((rows, tunings), numbers)| (rows, tunings, numbers, rest.take(tunings.len(), &widths)))
            .collect();
        let queue = Mutex::new(blocks.into_iter());
        let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
        let work = |worker: &mut Worker| {
            while let Some((rows, tunings, numbers, mut outputs)) = next() {
                for (i, row) in rows.chunks_exact_mut(width).enumerate() {
                    let numbers = &numbers[i * joints..(i + 1) * joints];
                    let command = match drive {
                        Drive::Targets(_) => Command::Targets(numbers),
                        Drive::Torques(_) => Command::Torques(numbers),
                    };
                    worker.step(row, tunings[i].as_ref(), command, &mut outputs.take(1, &widths));
                }
            }
        };
        let workers = &mut self.workers;
        self.pool.in_place_scope(|scope| {
            for worker in workers.iter_mut() {
                scope.spawn(|_| work(worker));
            }
        });
        Ok(())
    }

    fn save(&self) -> IntegrationState {
        IntegrationState {
            engine: ENGINE.to_string(),
            width: self.layout.width,
            values: self.environments.clone(),
            parameters: self.parameters.clone(),
        }
    }

    fn restore(&mut self, state: &IntegrationState) -> Result<(), SimError> {
        checks::saved(state, ENGINE, self.len(), self.layout.width)?;
        for (id, parameters) in state.parameters.iter().enumerate() {
            if self.parameters[id] != *parameters {
                self.set_parameters(id, parameters.clone())?;
            }
        }
        self.environments.copy_from_slice(&state.values);
        let ids: Vec<usize> = (0..self.len()).collect();
        self.refresh(&ids);
        Ok(())
    }
}
