//! The bookkeeping that all engines share, around what each of them does by itself.

use std::sync::Arc;

use lifelike_robot::Robot;

use crate::batch::{BatchState, EnvironmentParameters, IntegrationState};
use crate::checks;
use crate::constraint_wrenches::ConstraintWrenches;
use crate::error::SimError;
use crate::rows::{self, Sizes};
use crate::simulation::{Drive, Simulation};
use crate::terrain::Terrain;

/// The part of a simulation that differs between engines. [`Batched`] makes a [`Simulation`] of it: it checks all that
/// comes from outside, so an engine sees only environments that exist, arrays of the right length and finite states.
pub trait Engine: Send {
    /// Returns the engine's name: saved states carry it.
    fn name(&self) -> &'static str;

    /// Returns the uneven ground; `None`: level ground.
    fn terrain(&self) -> Option<&Arc<Terrain>>;

    /// Returns how many numbers [`Self::save`] writes for one environment.
    fn state_width(&self) -> usize;

    /// Puts an environment into a state, the root's quaternion normalised, and clears forces, warm starts and divergence.
    fn put(&mut self, id: usize, position: &[f64], velocity: &[f64]);

    /// Takes over an environment's parameters.
    ///
    /// # Errors
    /// Parameters that this engine cannot simulate; nothing has changed then.
    fn set_parameters(&mut self, id: usize, parameters: &EnvironmentParameters) -> Result<(), SimError>;

    /// Applies a force and a torque to a body until changed again.
    fn push(&mut self, id: usize, body: usize, force_w: [f32; 3], torque_w: [f32; 3]);

    /// Ends all pushes on an environment.
    fn clear_pushes(&mut self, id: usize);

    /// Writes the outputs of environments that did not step: poses, velocities, divergence; torques and forces are zero.
    fn observe(&mut self, ids: &[usize], state: &mut BatchState);

    /// Makes one policy step of all environments and writes all outputs.
    fn step(&mut self, drive: Drive<'_>, state: &mut BatchState);

    /// Writes [`Simulation::constraint_wrenches`] over zeros.
    fn constraint_wrenches(&mut self, drive: Drive<'_>, out: &mut ConstraintWrenches);

    /// Appends everything that an environment continues from, its parameters excepted.
    fn save(&self, id: usize, values: &mut Vec<f64>);

    /// Takes over what [`Self::save`] wrote.
    fn load(&mut self, id: usize, values: &[f64]);
}

impl<E: Engine + ?Sized> Engine for Box<E> {
    fn name(&self) -> &'static str {
        (**self).name()
    }
    fn terrain(&self) -> Option<&Arc<Terrain>> {
        (**self).terrain()
    }
    fn state_width(&self) -> usize {
        (**self).state_width()
    }
    fn put(&mut self, id: usize, position: &[f64], velocity: &[f64]) {
        (**self).put(id, position, velocity);
    }
    fn set_parameters(&mut self, id: usize, parameters: &EnvironmentParameters) -> Result<(), SimError> {
        (**self).set_parameters(id, parameters)
    }
    fn push(&mut self, id: usize, body: usize, force_w: [f32; 3], torque_w: [f32; 3]) {
        (**self).push(id, body, force_w, torque_w);
    }
    fn clear_pushes(&mut self, id: usize) {
        (**self).clear_pushes(id);
    }
    fn observe(&mut self, ids: &[usize], state: &mut BatchState) {
        (**self).observe(ids, state);
    }
    fn step(&mut self, drive: Drive<'_>, state: &mut BatchState) {
        (**self).step(drive, state);
    }
    fn constraint_wrenches(&mut self, drive: Drive<'_>, out: &mut ConstraintWrenches) {
        (**self).constraint_wrenches(drive, out);
    }
    fn save(&self, id: usize, values: &mut Vec<f64>) {
        (**self).save(id, values);
    }
    fn load(&mut self, id: usize, values: &[f64]) {
        (**self).load(id, values);
    }
}

/// N environments of an engine: its [`Simulation`].
pub struct Batched<E> {
    robot: Arc<Robot>,
    pub(crate) sizes: Sizes,
    parameters: Vec<EnvironmentParameters>,
    state: BatchState,
    pub(crate) engine: E,
}

impl<E: Engine> Batched<E> {
    /// Keeps the books of an engine that has so many environments of a robot, none of them randomised.
    pub fn with_engine(robot: Arc<Robot>, environments: usize, engine: E) -> Self {
        let sizes = Sizes::of(&robot);
        let mut simulation = Self {
            state: rows::allocate(environments, &sizes),
            parameters: vec![EnvironmentParameters::default(); environments],
            sizes,
            robot,
            engine,
        };
        simulation.observe_all();
        simulation
    }

    fn observe_all(&mut self) {
        let ids: Vec<usize> = (0..self.len()).collect();
        self.engine.observe(&ids, &mut self.state);
    }
}

impl<E: Engine> Simulation for Batched<E> {
    fn engine(&self) -> &str {
        self.engine.name()
    }

    fn robot(&self) -> &Arc<Robot> {
        &self.robot
    }

    fn len(&self) -> usize {
        self.parameters.len()
    }

    fn terrain(&self) -> Option<&Arc<Terrain>> {
        self.engine.terrain()
    }

    fn state(&self) -> &BatchState {
        &self.state
    }

    fn reset(&mut self, ids: &[usize], positions: &[f64], velocities: &[f64]) -> Result<(), SimError> {
        let Sizes { nq, nv, root_q, .. } = self.sizes;
        checks::reset(ids, self.len(), positions, velocities, &self.sizes)?;
        for (i, &id) in ids.iter().enumerate() {
            let position = checks::normalised(&positions[i * nq..(i + 1) * nq], root_q);
            self.engine.put(id, &position, &velocities[i * nv..(i + 1) * nv]);
        }
        self.engine.observe(ids, &mut self.state);
        Ok(())
    }

    fn set_parameters(&mut self, id: usize, parameters: EnvironmentParameters) -> Result<(), SimError> {
        checks::environment(id, self.len())?;
        checks::parameters(&parameters, &self.sizes)?;
        self.engine.set_parameters(id, &parameters)?;
        self.parameters[id] = parameters;
        Ok(())
    }

    fn push(&mut self, id: usize, body: usize, force_w: [f32; 3], torque_w: [f32; 3]) -> Result<(), SimError> {
        checks::environment(id, self.len())?;
        checks::push(body, self.sizes.bodies, &force_w, &torque_w)?;
        self.engine.push(id, body, force_w, torque_w);
        Ok(())
    }

    fn clear_pushes(&mut self, id: usize) {
        if id < self.len() {
            self.engine.clear_pushes(id);
        }
    }

    fn step(&mut self, drive: Drive<'_>) -> Result<(), SimError> {
        checks::drive(&drive, self.len() * self.sizes.joints)?;
        self.engine.step(drive, &mut self.state);
        Ok(())
    }

    fn constraint_wrenches(&mut self, drive: Drive<'_>) -> Result<ConstraintWrenches, SimError> {
        checks::drive(&drive, self.len() * self.sizes.joints)?;
        let mut out = ConstraintWrenches::zeros(self.len(), self.sizes.bodies, self.sizes.joints);
        self.engine.constraint_wrenches(drive, &mut out);
        Ok(out)
    }

    fn save(&self) -> IntegrationState {
        let width = self.engine.state_width();
        let mut values = Vec::with_capacity(self.len() * width);
        (0..self.len()).for_each(|id| self.engine.save(id, &mut values));
        IntegrationState { engine: self.engine.name().to_string(), width, values, parameters: self.parameters.clone() }
    }

    fn restore(&mut self, state: &IntegrationState) -> Result<(), SimError> {
        checks::saved(state, self.engine.name(), self.len(), self.engine.state_width())?;
        for parameters in &state.parameters {
            checks::parameters(parameters, &self.sizes)?;
        }
        for (id, parameters) in state.parameters.iter().enumerate() {
            if self.parameters[id] != *parameters {
                self.set_parameters(id, parameters.clone())?;
            }
        }
        for (id, row) in state.values.chunks_exact(state.width).enumerate() {
            self.engine.load(id, row);
        }
        self.observe_all();
        Ok(())
    }
}
