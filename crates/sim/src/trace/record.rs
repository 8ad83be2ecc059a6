//! Traces of a simulation.

use lifelike_character::rotation::{Quat, from_wxyz, to_6d};
use lifelike_robot::Robot;

use super::{BlockTrace, Columns, Trace};
use crate::batch::BatchState;
use crate::constraint_wrenches::ConstraintWrenches;
use crate::error::SimError;
use crate::simulation::{Drive, Simulation};

/// Columns of an actuator's simulated state: position (rad), velocity (rad/s), torque of the motor (N m), from which S makes its current.
pub const ACTUATOR: [&str; 3] = ["position", "velocity", "torque"];

/// Columns of a rigid body's state (thesis 2.4.1): position (m), orientation as the first two columns of its matrix, linear
/// (m/s) and angular velocity (rad/s), in axes of the world.
pub const BODY: [&str; 15] = [
    "position_x",
    "position_y",
    "position_z",
    "orientation_a_x",
    "orientation_a_y",
    "orientation_a_z",
    "orientation_b_x",
    "orientation_b_y",
    "orientation_b_z",
    "velocity_x",
    "velocity_y",
    "velocity_z",
    "turn_x",
    "turn_y",
    "turn_z",
];

/// Columns of what holds a rigid body in the robot, about its centre of mass: torque (N m), then force (N).
pub const BODY_FORCE: [&str; 6] = ["torque_x", "torque_y", "torque_z", "force_x", "force_y", "force_z"];

/// Columns of the pose of a body's parent in the world: position (m) and quaternion.
pub const FRAME: [&str; 7] =
    ["position_x", "position_y", "position_z", "orientation_w", "orientation_x", "orientation_y", "orientation_z"];

/// Writes down one environment, step by step: after each step its actuators' state, the load of the rest of the robot
/// on them (f_C), and the targets that led there. It also keeps the places of its bodies and what holds them.
#[derive(Debug, Clone)]
pub struct Recorder {
    joints: Vec<String>,
    bodies: Vec<Moving>,
    environment: usize,
    rate: f64,
    source: String,
    /// Position, velocity, torque, load and target of each joint, a row for each step.
    rows: Vec<Vec<[f32; 5]>>,
    /// Position, orientation and wrench of each body that moves, and its parent's pose.
    body_rows: Vec<Vec<[f32; 20]>>,
}

impl Recorder {
    /// Records an environment of a simulation.
    pub fn new(simulation: &impl Simulation, environment: usize) -> Self {
        let robot = simulation.robot();
        let source = format!("{}, {}", robot.name, simulation.engine());
        Self {
            joints: robot.layout.joints.clone(),
            bodies: moving(robot),
            environment,
            rate: robot.control_hz,
            source,
            rows: Vec::new(),
            body_rows: Vec::new(),
        }
    }

    /// Takes one policy step of the simulation and writes it down.
    ///
    /// # Errors
    /// Those of [`Simulation::step`].
    pub fn step(&mut self, simulation: &mut impl Simulation, targets: &[f32]) -> Result<(), SimError> {
        simulation.step(Drive::Targets(targets))?;
        let wrenches = simulation.constraint_wrenches(Drive::Targets(targets))?;
        self.write(simulation.state(), &wrenches, targets);
        Ok(())
    }

    /// Writes down the state after a step that somebody else took, the wrenches in it, and the targets of all environments.
    pub fn write(&mut self, state: &BatchState, wrenches: &ConstraintWrenches, targets: &[f32]) {
        let (n, id) = (self.joints.len(), self.environment);
        let row = |j: usize| {
            let i = id * n + j;
            [state.joint_position[i], state.joint_velocity[i], state.torque[i], -wrenches.joint_load[i], targets[i]]
        };
        self.rows.push((0..n).map(row).collect());
        let environments = state.diverged.len().max(1);
        let count = state.body_position.len() / 3 / environments;
        let row = |own: &Moving| {
            let mut row = [0.0; 20];
            for (body, first) in [(own.body, 0), (own.parent, 13)] {
                let i = id * count + body;
                row[first..first + 3].copy_from_slice(&state.body_position[3 * i..3 * i + 3]);
                row[first + 3..first + 7].copy_from_slice(&state.body_orientation[4 * i..4 * i + 4]);
            }
            let i = id * count + own.body;
            row[7..13].copy_from_slice(&wrenches.constraint[6 * i..6 * i + 6]);
            row
        };
        self.body_rows.push(self.bodies.iter().map(row).collect());
    }

    /// Returns the trace, all its actuators of one class.
    pub fn trace(&self, name: &str, class: &str) -> Trace {
        let column = |joint: usize, which: usize| -> Vec<f64> {
            self.rows.iter().map(|row| f64::from(row[joint][which])).collect()
        };
        let block = |(joint, name): (usize, &String)| {
            let state = [0, 1, 2].map(|which| column(joint, which));
            BlockTrace {
                name: name.clone(),
                class: class.into(),
                simulated: Columns::new(&std::array::from_fn::<_, 3, _>(|i| (ACTUATOR[i], &state[i][..]))),
                force: Columns::new(&[("load", &column(joint, 3))]),
                reference: Columns::new(&[("position", &column(joint, 4))]),
                ..BlockTrace::default()
            }
        };
        let blocks = self.joints.iter().enumerate().map(block).collect();
        Trace { name: name.into(), source: self.source.clone(), rate: self.rate, blocks }
    }

    /// Returns the trace of the bodies that move, all of one class. Velocities are the poses' change since the step before.
    pub fn bodies(&self, name: &str, class: &str) -> Trace {
        let block = |(i, own): (usize, &Moving)| {
            let orientation = |row: &[f32; 20]| {
                from_wxyz([row[3], row[4], row[5], row[6]].map(f64::from)).unwrap_or_else(Quat::identity)
            };
            let (mut state, mut force, mut frame) = (Vec::new(), Vec::new(), Vec::new());
            for (step, rows) in self.body_rows.iter().enumerate() {
                let (row, before) = (&rows[i], &self.body_rows[step.saturating_sub(1)][i]);
                let turn = (orientation(row) * orientation(before).inverse()).scaled_axis() * self.rate;
                state.extend(&row[..3]);
                state.extend(to_6d(&orientation(row)).map(|x| x as f32));
                state.extend((0..3).map(|k| (row[k] - before[k]) * self.rate as f32));
                state.extend(turn.iter().map(|x| *x as f32));
                force.extend(&row[7..13]);
                frame.extend(&row[13..]);
            }
            BlockTrace {
                name: own.name.clone(),
                class: class.into(),
                frame: Columns { names: FRAME.map(String::from).to_vec(), values: frame },
                simulated: Columns { names: BODY.map(String::from).to_vec(), values: state },
                force: Columns { names: BODY_FORCE.map(String::from).to_vec(), values: force },
                ..BlockTrace::default()
            }
        };
        let blocks = self.bodies.iter().enumerate().map(block).collect();
        Trace { name: name.into(), source: self.source.clone(), rate: self.rate, blocks }
    }
}

/// A body that some joint moves.
#[derive(Debug, Clone)]
struct Moving {
    body: usize,
    parent: usize,
    name: String,
}

fn moving(robot: &Robot) -> Vec<Moving> {
    let bodies = &robot.character.bodies;
    let mut moves = vec![false; bodies.len()];
    for (i, body) in bodies.iter().enumerate().skip(1) {
        moves[i] = moves[body.parent] || !body.joints.is_empty();
    }
    let of = |(i, body): (usize, &lifelike_character::Body)| Moving {
        body: i,
        parent: body.parent,
        name: body.name.clone(),
    };
    bodies.iter().enumerate().filter(|(i, _)| moves[*i]).map(of).collect()
}
