//! Traces of a simulation.

use super::{BlockTrace, Columns, Trace};
use crate::constraint_wrenches::ConstraintWrenches;
use crate::error::SimError;
use crate::simulation::{Drive, Simulation};

/// Columns of an actuator's simulated state: position (rad), velocity (rad/s).
pub const ACTUATOR: [&str; 2] = ["position", "velocity"];

/// Writes down one environment's actuators, step by step: after each step their state, the load that the rest of the robot is to
/// them (f_C), and the target that led there.
#[derive(Debug, Clone)]
pub struct Recorder {
    joints: Vec<String>,
    rate: f64,
    source: String,
    /// Position, velocity, load and target of each joint, a row for each step.
    rows: Vec<Vec<[f32; 4]>>,
}

impl Recorder {
    /// Records the actuators of a simulation's robot.
    pub fn new(simulation: &impl Simulation) -> Self {
        let robot = simulation.robot();
        Self {
            joints: robot.layout.joints.clone(),
            rate: robot.control_hz,
            source: format!("{}, {}", robot.name, simulation.engine()),
            rows: Vec::new(),
        }
    }

    /// Takes one policy step of the simulation and writes it down for an environment.
    ///
    /// # Errors
    /// Those of [`Simulation::step`].
    pub fn step(
        &mut self,
        simulation: &mut impl Simulation,
        targets: &[f32],
        environment: usize,
    ) -> Result<(), SimError> {
        simulation.step(Drive::Targets(targets))?;
        let wrenches = simulation.constraint_wrenches(Drive::Targets(targets))?;
        self.push(simulation, &wrenches, targets, environment);
        Ok(())
    }

    fn push(&mut self, simulation: &impl Simulation, wrenches: &ConstraintWrenches, targets: &[f32], id: usize) {
        let (state, n) = (simulation.state(), self.joints.len());
        let row = |j: usize| {
            let i = id * n + j;
            [state.joint_position[i], state.joint_velocity[i], -wrenches.joint_load[i], targets[i]]
        };
        self.rows.push((0..n).map(row).collect());
    }

    /// Returns the trace, all its actuators of one class.
    pub fn trace(self, name: &str, class: &str) -> Trace {
        let column = |joint: usize, which: usize| -> Vec<f64> {
            self.rows.iter().map(|row| f64::from(row[joint][which])).collect()
        };
        let block = |(joint, name): (usize, &String)| BlockTrace {
            name: name.clone(),
            class: class.into(),
            simulated: Columns::new(&[(ACTUATOR[0], &column(joint, 0)), (ACTUATOR[1], &column(joint, 1))]),
            force: Columns::new(&[("load", &column(joint, 2))]),
            reference: Columns::new(&[("position", &column(joint, 3))]),
            ..BlockTrace::default()
        };
        let blocks = self.joints.iter().enumerate().map(block).collect();
        Trace { name: name.into(), source: self.source, rate: self.rate, blocks }
    }
}
