//! A substitute for a real robot: a simulation richer than the nominal one, with hidden parameters.
//!
//! A [`Twin`] adds these effects to the servos:
//!
//! - a motor with resistance and back-EMF behind firmware that reads a 12-bit encoder;
//! - friction that grows at rest and under load (BAM's model M6);
//! - play in the gear, and flex before and behind the encoder;
//! - delayed commands, and a supply whose voltage sags under the load of all servos.
//!
//! Masses of its parts differ slightly. [`TwinSpec`] has the distributions of all parameters, [`DriveTrain`] is one
//! servo, and the engine moves the parts. The output is that of sensors: joints by their encoders, bodies by their true
//! poses.

mod drive_train;
mod spec;

use std::collections::VecDeque;
use std::sync::Arc;

use lifelike_robot::Robot;
use rayon::prelude::*;

pub use drive_train::{Around, DriveTrain};
pub use spec::{TwinServo, TwinSpec, nominal_torque_constant};

use crate::batch::{BatchState, EnvironmentParameters, IntegrationState};
use crate::checks;
use crate::constraint_wrenches::ConstraintWrenches;
use crate::error::SimError;
use crate::registry::SimulationSpec;
use crate::simulation::{Drive, Simulation};
use crate::terrain::Terrain;

/// Measurements of a servo beside position and velocity.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Electric {
    /// Current through the winding, in the servo's steps (A).
    pub current: f32,
    /// Voltage on the winding (V).
    pub voltage: f32,
}

/// Numbers of a servo in a saved state, beside the commands that it has not heard yet and its encoder's readings.
const SAVED: usize = 9;

/// N twins of one robot, side by side. Commands are targets; torques cannot be commanded.
///
/// ```
/// use std::sync::Arc;
/// use lifelike_robot::Robot;
/// use lifelike_sim::twin::{Twin, TwinSpec};
/// use lifelike_sim::{Drive, Simulation, SimulationSpec};
///
/// let robot = Arc::new(Robot::load("lima")?);
/// let targets: Vec<f32> = robot.default_pose.iter().map(|&q| q as f32).collect();
/// let mut nominal = SimulationSpec::new(1).build(robot.clone())?;
/// let mut twin = Twin::new(&robot, &TwinSpec::default(), &SimulationSpec::new(1))?;
/// for _ in 0..20 {
///     nominal.step(Drive::Targets(&targets))?;
///     twin.step(Drive::Targets(&targets))?;
/// }
/// assert_ne!(nominal.state().joint_position, twin.state().joint_position);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Twin {
    /// The parts: an engine that is driven by torques.
    parts: Box<dyn Simulation>,
    robot: Arc<Robot>,
    name: String,
    spec: TwinSpec,
    servos: Vec<TwinServo>,
    shared_resistance: f64,
    /// Physics steps of a step.
    substeps: usize,
    /// `[N, J]`.
    trains: Vec<DriveTrain>,
    /// Current that each environment's servos draw together (A), `[N]`.
    drawn: Vec<f64>,
    /// The latest commands, the newest first, `[steps][N, J]`.
    commands: Vec<Vec<f32>>,
    /// Encoder readings of the last control steps, the newest first, `[window][N, J]`: what reported velocities are differences of.
    readings: VecDeque<Vec<f64>>,
    /// Environments whose commands of before are none, `[N]`.
    fresh: Vec<bool>,
    torques: Vec<f32>,
    parameters: Vec<EnvironmentParameters>,
    electric: Vec<Electric>,
    state: BatchState,
}

impl Twin {
    /// Builds twins of a robot in the engine, on the ground and with the threads of `simulation`.
    ///
    /// # Errors
    /// [`SimError::State`] for a spec out of range, and as [`SimulationSpec::build`].
    pub fn new(robot: &Arc<Robot>, spec: &TwinSpec, simulation: &SimulationSpec) -> Result<Self, SimError> {
        check(spec)?;
        let substeps = (spec.physics_hz / robot.control_hz - 1e-9).ceil().max(1.0);
        let spec = TwinSpec { physics_hz: substeps * robot.control_hz, ..spec.clone() };
        if let Some(i) = robot.actuators.parameters.iter().position(|nominal| nominal.torque_max <= 0.0) {
            let expected = format!("a motor for joint '{}' of a twin", robot.layout.joints[i]);
            return Err(SimError::State { expected, got: "none".into() });
        }
        let servos: Vec<TwinServo> = robot
            .character
            .scalar_joints()
            .zip(&robot.actuators.parameters)
            .map(|(joint, nominal)| spec.servo(&joint.name, nominal, joint.armature))
            .collect();
        if let Some(i) = servos.iter().position(|servo| servo.rotor <= 0.0) {
            let expected = format!("a rotor's inertia (armature) for joint '{}' of a twin", robot.layout.joints[i]);
            return Err(SimError::State { expected, got: "0".into() });
        }
        let parts = simulation.build(Arc::new(spec.robot(robot)))?;
        let (n, joints) = (parts.len(), robot.joints());
        let longest = servos.iter().fold(0.0_f64, |most, servo| most.max(servo.delay));
        let kept = 1 + (longest * robot.control_hz).ceil() as usize;
        let mut twin = Self {
            name: format!("twin {} of {}", spec.seed, parts.engine()),
            robot: robot.clone(),
            shared_resistance: spec.shared_resistance(&servos),
            substeps: substeps as usize,
            trains: vec![DriveTrain::default(); n * joints],
            drawn: vec![0.0; n],
            commands: vec![vec![0.0; n * joints]; kept],
            readings: vec![vec![0.0; n * joints]; window_steps(spec.velocity_window, robot.control_hz)].into(),
            fresh: vec![true; n],
            torques: vec![0.0; n * joints],
            parameters: vec![EnvironmentParameters::default(); n],
            electric: vec![Electric::default(); n * joints],
            state: parts.state().clone(),
            spec,
            servos,
            parts,
        };
        (0..n).for_each(|id| twin.rest(id));
        Ok(twin)
    }

    /// Returns what the servos tell of current and voltage, `[N, J]`.
    pub fn electric(&self) -> &[Electric] {
        &self.electric
    }

    /// Servos of an environment rest where its parts are.
    fn rest(&mut self, id: usize) {
        let row = id * self.servos.len()..(id + 1) * self.servos.len();
        let state = self.parts.state();
        for (train, (angle, velocity)) in self.trains[row.clone()]
            .iter_mut()
            .zip(state.joint_position[row.clone()].iter().zip(&state.joint_velocity[row.clone()]))
        {
            *train = DriveTrain { velocity: f64::from(*velocity), ..DriveTrain::at(f64::from(*angle)) };
        }
        // As if it had moved at that velocity before.
        for (steps, readings) in self.readings.iter_mut().enumerate() {
            let ago = steps as f64 / self.robot.control_hz;
            let trains = &self.trains[row.clone()];
            readings[row.clone()].iter_mut().zip(trains).for_each(|(x, own)| *x = own.encoder - ago * own.velocity);
        }
        self.electric[row.clone()].fill(Electric::default());
        self.torques[row].fill(0.0);
        (self.drawn[id], self.fresh[id]) = (0.0, true);
        self.copy(id);
    }

    /// Reports an environment's parts as they are.
    fn copy(&mut self, id: usize) {
        crate::rows::copy(self.parts.state(), &mut self.state, id, &crate::rows::Sizes::of(&self.robot));
    }

    /// One physics step of all servos: their torques.
    fn drive(&mut self, substep: usize) {
        let (joints, dt) = (self.servos.len(), 1.0 / self.spec.physics_hz);
        let tick = std::f64::consts::TAU / f64::from(self.spec.encoder_bits).exp2();
        let Self { parts, servos, commands, parameters, spec, shared_resistance, substeps, .. } = self;
        let (state, servos, commands, shared_resistance, substeps) =
            (parts.state(), &*servos, &*commands, *shared_resistance, *substeps);
        let supply = servos.first().map_or(0.0, |servo| servo.motor.supply);
        let trains = self.trains.par_chunks_mut(joints.max(1)).zip(self.torques.par_chunks_mut(joints.max(1)));
        trains.zip(&mut self.drawn).zip(&*parameters).enumerate().for_each(
            |(id, (((trains, torques), drawn), own))| {
                let supply = (supply - shared_resistance * *drawn).max(0.0);
                for (j, ((train, servo), torque)) in trains.iter_mut().zip(servos).zip(torques).enumerate() {
                    let i = id * joints + j;
                    // A command is heard when its delay has passed since its step began.
                    let late = ((servo.delay * spec.physics_hz).round() as usize).saturating_sub(substep);
                    let target = f64::from(commands[late.div_ceil(substeps).min(commands.len() - 1)][i]);
                    let factor = |list: &[f32]| list.get(j).map_or(1.0, |x| f64::from(*x));
                    let around = Around {
                        target,
                        part: f64::from(state.joint_position[i]),
                        part_velocity: f64::from(state.joint_velocity[i]),
                        supply,
                        gain: factor(&own.kp_scale),
                        strength: factor(&own.strength_scale),
                        tick,
                    };
                    *torque = train.step(servo, &around, dt) as f32;
                }
                // The supply's own capacity smooths what it is asked for.
                *drawn = 0.5 * (*drawn + trains.iter().map(|train| train.drawn).sum::<f64>());
            },
        );
    }
}

fn check(spec: &TwinSpec) -> Result<(), SimError> {
    if !(10.0..=1e6).contains(&spec.physics_hz) {
        let expected = "'physics_hz' of a twin from 10 to 1000000".into();
        return Err(SimError::State { expected, got: spec.physics_hz.to_string() });
    }
    let shares = [
        ("mass", spec.mass, 1.0),
        ("center_of_mass", spec.center_of_mass, 1.0),
        ("assembly", spec.assembly[0], 0.1),
        ("assembly", spec.assembly[1], 0.5),
        ("spread", spec.spread, 0.3),
        ("friction", spec.friction, 100.0),
        ("sag", spec.sag, 1.0),
        ("backlash", spec.backlash, 1.0),
        ("gear_flex", spec.gear_flex, 1.0),
        ("link_flex", spec.link_flex, 1.0),
        ("delay", spec.delay[0].min(spec.delay[1]), 1.0),
        ("delay", spec.delay[1].max(spec.delay[0]), 1.0),
        ("velocity_window", spec.velocity_window, 1.0),
        ("velocity_step", spec.velocity_step, 10.0),
        ("current_step", spec.current_step, 1.0),
    ];
    for (name, value, most) in shares {
        if !(0.0..=most).contains(&value) {
            let expected = format!("'{name}' of a twin from 0 to {most}");
            return Err(SimError::State { expected, got: value.to_string() });
        }
    }
    let positive = [("resistance", spec.resistance), ("gear_flex + link_flex", spec.gear_flex + spec.link_flex)];
    for (name, value) in positive {
        if !(value.is_finite() && value > 1e-4) {
            let expected = format!("'{name}' of a twin above 0.0001");
            return Err(SimError::State { expected, got: value.to_string() });
        }
    }
    match spec.encoder_bits {
        4..=32 => Ok(()),
        bits => Err(SimError::State { expected: "'encoder_bits' from 4 to 32".into(), got: bits.to_string() }),
    }
}

/// Control steps of a velocity's window.
fn window_steps(window: f64, control_hz: f64) -> usize {
    ((window * control_hz).round() as usize).max(1)
}

/// Returns the velocity that firmware reports: the encoder's difference over a window of control steps, then in steps of the register.
fn reported_velocity([before, now]: [f64; 2], steps: usize, control_hz: f64, step: f64) -> f32 {
    stepped((now - before) * control_hz / steps as f64, step)
}

/// A number in steps of a sensor.
fn stepped(x: f64, step: f64) -> f32 {
    if step > 0.0 { ((x / step).round() * step) as f32 } else { x as f32 }
}

impl Simulation for Twin {
    fn engine(&self) -> &str {
        &self.name
    }

    fn robot(&self) -> &Arc<Robot> {
        &self.robot
    }

    fn len(&self) -> usize {
        self.parts.len()
    }

    fn terrain(&self) -> Option<&Arc<Terrain>> {
        self.parts.terrain()
    }

    fn state(&self) -> &BatchState {
        &self.state
    }

    fn reset(&mut self, ids: &[usize], positions: &[f64], velocities: &[f64]) -> Result<(), SimError> {
        self.parts.reset(ids, positions, velocities)?;
        ids.iter().for_each(|id| self.rest(*id));
        Ok(())
    }

    /// As the engine's; gains κ_P and strengths are the servos', factors on κ_D and armature are left out.
    fn set_parameters(&mut self, id: usize, parameters: EnvironmentParameters) -> Result<(), SimError> {
        self.parts.set_parameters(id, parameters.clone())?;
        self.parameters[id] = parameters;
        Ok(())
    }

    fn push(&mut self, id: usize, body: usize, force_w: [f32; 3], torque_w: [f32; 3]) -> Result<(), SimError> {
        self.parts.push(id, body, force_w, torque_w)
    }

    fn clear_pushes(&mut self, id: usize) {
        self.parts.clear_pushes(id);
    }

    /// # Errors
    /// As [`Simulation::step`]; [`SimError::State`] for torques.
    fn step(&mut self, drive: Drive<'_>) -> Result<(), SimError> {
        let joints = self.servos.len();
        checks::drive(&drive, self.len() * joints)?;
        let Drive::Targets(targets) = drive else {
            return Err(SimError::State {
                expected: "joint targets for a twin's servos".into(),
                got: "torques".into(),
            });
        };
        self.commands.rotate_right(1);
        self.commands[0].copy_from_slice(targets);
        for id in 0..self.len() {
            if std::mem::take(&mut self.fresh[id]) {
                let row = id * joints..(id + 1) * joints;
                self.commands
                    .iter_mut()
                    .for_each(|command| command[row.clone()].copy_from_slice(&targets[row.clone()]));
            }
        }
        let mut squared = vec![0.0_f32; self.torques.len()];
        for substep in 0..self.substeps {
            self.drive(substep);
            self.parts.step(Drive::Torques(&self.torques))?;
            squared.iter_mut().zip(&self.torques).for_each(|(sum, torque)| *sum += torque * torque);
        }
        let before = self.readings.back().cloned().unwrap_or_default();
        self.readings.rotate_right(1);
        for id in 0..self.len() {
            self.copy(id);
            if self.state.diverged[id] {
                continue;
            }
            for i in id * joints..(id + 1) * joints {
                let train = &self.trains[i];
                self.state.joint_position[i] = train.encoder as f32;
                let (rate, step) = (self.robot.control_hz, self.spec.velocity_step);
                self.state.joint_velocity[i] =
                    reported_velocity([before[i], train.encoder], self.readings.len(), rate, step);
                self.readings[0][i] = train.encoder;
                self.state.torque_squared[i] = squared[i] / self.substeps as f32;
                let current_step = self.servos[i % joints].current_step;
                self.electric[i] =
                    Electric { current: stepped(train.current, current_step), voltage: train.voltage as f32 };
            }
        }
        Ok(())
    }

    /// As [`Simulation::constraint_wrenches`] under the torques that the servos make now, whatever the drive.
    fn constraint_wrenches(&mut self, drive: Drive<'_>) -> Result<ConstraintWrenches, SimError> {
        checks::drive(&drive, self.torques.len())?;
        self.parts.constraint_wrenches(Drive::Torques(&self.torques))
    }

    fn save(&self) -> IntegrationState {
        let (inner, joints) = (self.parts.save(), self.servos.len());
        let mut values = Vec::new();
        for id in 0..self.len() {
            values.extend(&inner.values[id * inner.width..(id + 1) * inner.width]);
            for i in id * joints..(id + 1) * joints {
                let t = &self.trains[i];
                let (position, velocity) = (self.state.joint_position[i], self.state.joint_velocity[i]);
                values.extend([t.angle, t.velocity, t.torque, t.current, t.voltage, t.drawn, t.encoder]);
                values.extend([position, velocity].map(f64::from));
                values.extend(self.commands.iter().map(|command| f64::from(command[i])));
                values.extend(self.readings.iter().map(|readings| readings[i]));
            }
            values.extend([self.drawn[id], f64::from(u8::from(self.fresh[id]))]);
        }
        let width = inner.width + self.own_width();
        IntegrationState { engine: self.name.clone(), width, values, parameters: inner.parameters }
    }

    fn restore(&mut self, state: &IntegrationState) -> Result<(), SimError> {
        let width = state.width.saturating_sub(self.own_width());
        checks::saved(state, &self.name, self.len(), width + self.own_width())?;
        let rows = state.values.chunks_exact(state.width.max(1));
        self.parts.restore(&IntegrationState {
            engine: self.parts.engine().to_string(),
            width,
            values: rows.clone().flat_map(|row| &row[..width]).copied().collect(),
            parameters: state.parameters.clone(),
        })?;
        self.parameters.clone_from(&state.parameters);
        let (joints, kept) = (self.servos.len(), self.commands.len());
        for (id, row) in rows.enumerate() {
            self.copy(id);
            let each = SAVED + kept + self.readings.len();
            let (own, rest) = row[width..].split_at(joints * each);
            for (j, numbers) in own.chunks_exact(each).enumerate() {
                let i = id * joints + j;
                let [angle, velocity, torque, current, voltage, drawn, encoder] = std::array::from_fn(|k| numbers[k]);
                self.trains[i] = DriveTrain { angle, velocity, torque, current, voltage, drawn, encoder };
                self.torques[i] = torque as f32;
                self.state.joint_position[i] = numbers[SAVED - 2] as f32;
                self.state.joint_velocity[i] = numbers[SAVED - 1] as f32;
                let step = self.servos[j].current_step;
                self.electric[i] = Electric { current: stepped(current, step), voltage: voltage as f32 };
                self.commands.iter_mut().zip(&numbers[SAVED..]).for_each(|(command, x)| command[i] = *x as f32);
                self.readings.iter_mut().zip(&numbers[SAVED + kept..]).for_each(|(readings, x)| readings[i] = *x);
            }
            (self.drawn[id], self.fresh[id]) = (rest[0], rest[1] != 0.0);
        }
        Ok(())
    }
}

impl Twin {
    /// Numbers of one environment in a saved state beside the engine's own.
    fn own_width(&self) -> usize {
        self.servos.len() * (SAVED + self.commands.len() + self.readings.len()) + 2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One count of a 12-bit encoder over 16 steps of 4 ms is 0.2289 rpm, and so is one step of the register. Over one
    /// step it is 16.
    #[test]
    fn velocities_are_differences_over_the_window_in_steps_of_the_register() {
        let (count, step) = (std::f64::consts::TAU / 4096.0, TwinSpec::default().velocity_step);
        let of = |counts: f64, steps| {
            f64::from(reported_velocity([7.0 * count, (7.0 + counts) * count], steps, 250.0, step))
        };
        assert_eq!(window_steps(0.064, 250.0), 16);
        assert_eq!([window_steps(0.064, 50.0), window_steps(0.0, 250.0)], [3, 1]);
        for (counts, steps, registers) in
            [(0.0, 16, 0.0), (1.0, 16, 1.0), (5.0, 16, 5.0), (-3.0, 8, -6.0), (1.0, 1, 16.0)]
        {
            assert!((of(counts, steps) - registers * step).abs() < 1e-6, "{counts} counts in {steps} steps");
        }
    }
}
