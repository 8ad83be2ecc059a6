//! Ctrl-C in long calls: Python's signal handlers run between two steps of physics or training.

use std::sync::{Arc, Mutex, PoisonError};

use lifelike_robot::Robot;
use lifelike_sim::{
    BatchState, ConstraintWrenches, Drive, EnvironmentParameters, IntegrationState, SimError, Simulation, Terrain,
};
use pyo3::prelude::*;

/// The exception of a signal handler, such as `KeyboardInterrupt`, until the call that it interrupts returns.
#[derive(Clone, Default)]
pub struct Interrupt(Arc<Mutex<Option<PyErr>>>);

impl Interrupt {
    /// Keeps an exception for [`Self::result`].
    pub fn set(&self, exception: PyErr) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(exception);
    }

    /// Runs the handlers of signals that arrived. Returns true when one of them raised.
    pub fn check(&self) -> bool {
        match Python::attach(|py| py.check_signals()) {
            Ok(()) => false,
            Err(exception) => {
                self.set(exception);
                true
            }
        }
    }

    /// Returns the result, or raises the exception of a handler instead.
    pub fn result<T>(&self, otherwise: PyResult<T>) -> PyResult<T> {
        match self.0.lock().unwrap_or_else(PoisonError::into_inner).take() {
            Some(exception) => Err(exception),
            None => otherwise,
        }
    }

    /// Returns a simulation whose steps fail after an interrupt.
    pub fn guard(&self, simulation: Box<dyn Simulation>) -> Box<dyn Simulation> {
        Box::new(Interruptible { simulation, interrupt: self.clone() })
    }
}

struct Interruptible {
    simulation: Box<dyn Simulation>,
    interrupt: Interrupt,
}

impl Simulation for Interruptible {
    fn engine(&self) -> &str {
        self.simulation.engine()
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
        self.simulation.state()
    }
    fn reset(&mut self, ids: &[usize], positions: &[f64], velocities: &[f64]) -> Result<(), SimError> {
        self.simulation.reset(ids, positions, velocities)
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
        if self.interrupt.check() {
            return Err(SimError::State { expected: "a step".into(), got: "an interrupt".into() });
        }
        self.simulation.step(drive)
    }
    fn constraint_wrenches(&mut self, drive: Drive<'_>) -> Result<ConstraintWrenches, SimError> {
        self.simulation.constraint_wrenches(drive)
    }
    fn save(&self) -> IntegrationState {
        self.simulation.save()
    }
    fn restore(&mut self, state: &IntegrationState) -> Result<(), SimError> {
        self.simulation.restore(state)
    }
}
