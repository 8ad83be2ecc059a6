//! A simulated machine: our physics behind the sensors, motors and wires of a robot. `lifelike simulate-robot` puts it behind
//! UDP, `lifelike bench runtime` behind a bus in memory.

mod faults;
mod link;
mod memory;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use lifelike_character::rotation::from_wxyz;
use lifelike_character::{Quat, Vec3};
use lifelike_robot::{Profile, Robot};
use lifelike_runtime::bus::External;
use lifelike_runtime::udp::packet::Received;
use lifelike_runtime::{Facts, Measurement, Mode};
use lifelike_sim::{Drive, SimError, Simulation};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

pub use faults::{Fault, Scheduled};
pub use link::Link;
pub use memory::MemoryBus;

/// Temperature of the room, and rise of a motor at its continuous rating (degrees Celsius).
const ROOM: f32 = 25.0;
const RISE: f32 = 50.0;
/// Time constant of the motors' temperature (s).
const THERMAL_TIME: f32 = 60.0;
/// Resistance of the battery (V per W of mechanical power).
const SAG: f32 = 0.004;
/// Force of a push, in weights of the robot.
const PUSH: f32 = 1.5;
/// Time without a command after which the machine brakes by itself (ns).
const WATCHDOG: u64 = 100_000_000;

/// Properties of a machine beside its physics.
#[derive(Debug, Clone)]
pub struct SensorOptions {
    /// Standard deviation of joint positions (rad); velocities and gyroscope have ten times, the accelerometer fifty times (m/s²),
    /// orientation has half of it.
    pub noise: f32,
    /// Bias of each axis of the gyroscope (rad/s); the accelerometer has ten times (m/s²).
    pub bias: f32,
    /// Seed of the noise.
    pub seed: u64,
    /// Voltage of the battery without load (V).
    pub battery: f32,
    /// Root state from outside, as motion capture would give it.
    pub has_external: bool,
    /// Time for which the root is held after the first drive (s).
    pub gantry: f64,
}

/// Physics of one robot with one command per physics step.
pub struct SimulatedRobot {
    simulation: Box<dyn Simulation>,
    robot: Arc<Robot>,
    facts: Facts,
    options: SensorOptions,
    command: Received,
    targets: Vec<f32>,
    heat: Vec<f32>,
    /// Specific force at the root over the last step (m/s², its own frame).
    force_b: Vec3,
    continuous: Vec<f32>,
    rng: ChaCha8Rng,
    sequence: u32,
    /// Time (ns), that of a step, of the first drive, and of the last command.
    time: u64,
    step: u64,
    driven: Option<u64>,
    commanded: u64,
    faults: Vec<Scheduled>,
}

/// Returns a robot whose policy step is one physics step, so that every physics step may have its own command.
pub fn stepwise(robot: &Robot) -> Result<Robot, crate::error::CliError> {
    let physics_hz = robot.control_hz * robot.substeps as f64;
    let profile = Profile { control_hz: Some(physics_hz), physics_hz: Some(physics_hz), ..robot.profile.clone() };
    Ok(Robot::from_character(Arc::clone(&robot.character), profile)?)
}

impl SimulatedRobot {
    /// A machine of a robot in its default pose. The simulation is one of [`stepwise`].
    pub fn new(robot: &Robot, simulation: Box<dyn Simulation>, options: SensorOptions) -> Self {
        let step = (simulation.robot().timestep() * 1e9).round() as u64;
        let joints = robot.joints();
        Self {
            robot: Arc::clone(simulation.robot()),
            facts: Facts::of(robot, 1e9 / step as f64, 10_000.0),
            command: Received::new(joints),
            targets: vec![0.0; joints],
            heat: vec![0.0; joints],
            force_b: Vec3::z() * robot.character.gravity.norm(),
            continuous: robot.continuous_torques().iter().map(|x| *x as f32).collect(),
            rng: lifelike_checkpoint::rng::stream(options.seed, "machine", 0, 0),
            sequence: 0,
            time: 0,
            step,
            driven: None,
            commanded: 0,
            faults: Vec::new(),
            options,
            simulation,
        }
    }

    /// Returns the machine with faults.
    #[must_use]
    pub fn with_faults(self, faults: Vec<Scheduled>) -> Self {
        Self { faults, ..self }
    }

    /// Returns the facts that it gives about itself.
    pub fn facts(&self) -> &Facts {
        &self.facts
    }

    /// Returns the time of a physics step (ns).
    pub fn step_ns(&self) -> u64 {
        self.step
    }

    /// Returns the physics.
    pub fn simulation_mut(&mut self) -> &mut dyn Simulation {
        self.simulation.as_mut()
    }

    /// Returns the physics.
    pub fn simulation(&self) -> &dyn Simulation {
        self.simulation.as_ref()
    }

    /// Returns the time since the first drive (s); none before it.
    pub fn seconds(&self) -> Option<f64> {
        self.driven.map(|driven| (self.time - driven) as f64 * 1e-9)
    }

    /// Obeys a command from now on.
    pub fn command(&mut self, command: &Received) {
        self.command.clone_from(command);
        self.commanded = self.time;
        if command.mode == Mode::Position {
            self.driven.get_or_insert(self.time);
        }
    }

    /// Makes one physics step.
    ///
    /// # Errors
    /// The physics fails as a whole.
    pub fn advance(&mut self) -> Result<(), SimError> {
        if self.time.saturating_sub(self.commanded) > WATCHDOG && self.command.mode == Mode::Position {
            self.command.mode = Mode::Damp;
            let gains = self.robot.actuators.parameters.iter().map(|p| p.kd as f32);
            self.command.kp.fill(0.0);
            self.command.kd.iter_mut().zip(gains).for_each(|(kd, own)| *kd = own);
        }
        let state = self.simulation.state();
        let seconds = self.driven.map_or(0.0, |driven| (self.time - driven) as f64 * 1e-9);
        for (j, actuator) in self.robot.actuators.parameters.iter().enumerate() {
            let (q, v) = (state.joint_position[j], state.joint_velocity[j]);
            let (kp, kd) = (actuator.kp as f32, actuator.kd as f32);
            let Received { position, kp: own_kp, kd: own_kd, .. } = &self.command;
            let is_dead = self.faults.iter().any(|fault| fault.kills_motor(j, seconds));
            // The target by which the engine's own gains give the torque of the command's.
            self.targets[j] = if is_dead {
                q + kd * v / kp
            } else if own_kp[j] == kp && own_kd[j] == kd {
                position[j]
            } else {
                q + (own_kp[j] * (position[j] - q) + (kd - own_kd[j]) * v) / kp
            };
        }
        let root = self.robot.character.root_body();
        self.simulation.clear_pushes(0);
        if self.faults.iter().any(|fault| fault.pushes(seconds)) {
            let weight = self.robot.character.mass() * self.robot.character.gravity.norm();
            self.simulation.push(0, root, [PUSH * weight as f32, 0.0, 0.0], [0.0; 3])?;
        }
        let before = self.root();
        self.simulation.step(Drive::Targets(&self.targets))?;
        self.time += self.step;
        if self.is_held() {
            self.hold()?;
        }
        let after = self.root();
        let acceleration = (after.1 - before.1) / (self.step as f64 * 1e-9) - self.robot.character.gravity;
        self.force_b = before.0.nlerp(&after.0, 0.5).inverse() * acceleration;
        let share = self.step as f32 * 1e-9 / THERMAL_TIME;
        let state = self.simulation.state();
        for (j, heat) in self.heat.iter_mut().enumerate() {
            *heat += (state.torque_squared[j] / self.continuous[j].powi(2) - *heat) * share;
        }
        Ok(())
    }

    /// Returns orientation and linear velocity (m/s, world) of the root.
    fn root(&self) -> (Quat, Vec3) {
        let state = self.simulation.state();
        let (q, v) = (&state.root_orientation, &state.linear_velocity_w);
        let orientation = from_wxyz([q[0], q[1], q[2], q[3]].map(f64::from)).unwrap_or_default();
        (orientation, Vec3::new(v[0].into(), v[1].into(), v[2].into()))
    }

    fn is_held(&self) -> bool {
        self.driven.is_none_or(|driven| ((self.time - driven) as f64) < self.options.gantry * 1e9)
    }

    /// Puts the root back to where it is by default, at rest.
    fn hold(&mut self) -> Result<(), SimError> {
        let character = &self.robot.character;
        let (mut q, mut v) = (self.robot.default_position(), vec![0.0; character.nv]);
        let state = self.simulation.state();
        for (i, joint) in character.scalar_joints().enumerate() {
            q[joint.q_index] = f64::from(state.joint_position[i]);
            v[joint.v_index] = f64::from(state.joint_velocity[i]);
        }
        character.follow(&mut q, &mut v);
        self.simulation.reset(&[0], &q, &v)
    }

    /// Writes what its sensors say now; returns false for a packet that a fault swallows.
    pub fn measure(&mut self, into: &mut Measurement) -> bool {
        let (root, _) = self.root();
        let state = self.simulation.state();
        let joints = state.joint_position.len();
        let rng = &mut self.rng;
        let noise = self.options.noise;
        let mut noisy = |x: f32, size: f32| if size > 0.0 { x + size * gaussian(rng) } else { x };
        self.sequence = self.sequence.wrapping_add(1);
        (into.sequence, into.clock, into.stop) = (self.sequence, self.time, false);
        let mut power = 0.0;
        for j in 0..joints {
            into.position[j] = noisy(state.joint_position[j], noise);
            into.velocity[j] = noisy(state.joint_velocity[j], 10.0 * noise);
            into.torque[j] = state.torque[j];
            into.temperature[j] = ROOM + RISE * self.heat[j];
            power += (state.torque[j] * state.joint_velocity[j]).abs();
        }
        into.battery = self.options.battery - SAG * power;
        let q = &state.root_orientation;
        let turned = [q[0], q[1], q[2], q[3]].map(|x| noisy(x, 0.5 * noise));
        let norm = turned.iter().map(|x| x * x).sum::<f32>().sqrt();
        into.orientation = turned.map(|x| x / norm);
        let w = &state.angular_velocity_w;
        let local = root.inverse() * Vec3::new(f64::from(w[0]), f64::from(w[1]), f64::from(w[2]));
        let (bias, force) = (self.options.bias, self.force_b);
        into.gyroscope_b = [local.x, local.y, local.z].map(|x| noisy(x as f32 + bias, 10.0 * noise));
        into.accelerometer_b = [force.x, force.y, force.z].map(|x| noisy(x as f32 + 10.0 * bias, 50.0 * noise));
        let three = |x: &[f32]| [x[0], x[1], x[2]];
        into.external = self.options.has_external.then(|| External {
            position: three(&state.root_position),
            linear_velocity_w: three(&state.linear_velocity_w),
        });
        let seconds = self.driven.map_or(0.0, |driven| (self.time - driven) as f64 * 1e-9);
        let is_driven = self.driven.is_some();
        self.faults.iter_mut().filter(|_| is_driven).all(|fault| fault.apply(seconds, into))
    }
}

/// A normally distributed number, by Marsaglia's polar method.
fn gaussian(rng: &mut ChaCha8Rng) -> f32 {
    loop {
        let (x, y) = (rng.random_range(-1.0f32..=1.0), rng.random_range(-1.0f32..=1.0));
        let square = x * x + y * y;
        if square > 0.0 && square < 1.0 {
            return x * (-2.0 * square.ln() / square).sqrt();
        }
    }
}
