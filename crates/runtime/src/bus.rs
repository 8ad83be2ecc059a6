//! The machine as the loop sees it: facts, measurements, commands.

use crate::error::RuntimeError;
use crate::gate::SafeCommand;

/// A connection to one machine. `receive` and `send` run in the loop: they must neither block nor allocate.
pub trait Bus {
    /// Asks the machine what it is. May block for a second; called before the loop.
    ///
    /// # Errors
    /// The machine does not answer, or its answer is malformed.
    fn facts(&mut self) -> Result<Facts, RuntimeError>;

    /// Writes the next packet that has arrived into `into`; returns false when none is waiting.
    ///
    /// # Errors
    /// The connection is broken. The loop goes on, and the gate treats the machine as lost.
    fn receive(&mut self, into: &mut Measurement) -> std::io::Result<bool>;

    /// Sends a command that passed the gate.
    ///
    /// # Errors
    /// The connection is broken. The loop goes on.
    fn send(&mut self, command: &SafeCommand) -> std::io::Result<()>;
}

/// Root state from outside of the robot, such as motion capture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct External {
    /// Root position (m, world).
    pub position: [f32; 3],
    /// Root linear velocity (m/s, world).
    pub linear_velocity_w: [f32; 3],
}

/// One packet of a robot's sensors. `J` joints in the order of [`Facts::joints`].
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    /// Number of the packet; each is one above the last.
    pub sequence: u32,
    /// Time of the measurement on the robot's clock (ns).
    pub clock: u64,
    /// The robot's own stop button or remote asks for a stop.
    pub stop: bool,
    /// Root orientation (`wxyz`, world).
    pub orientation: [f32; 4],
    /// Root angular velocity (rad/s, frame of the root).
    pub gyroscope_b: [f32; 3],
    /// Specific force at the root (m/s², frame of the root): gravity's reaction at rest; NaN where it is not measured.
    pub accelerometer_b: [f32; 3],
    /// Supply voltage (V); NaN where it is not measured.
    pub battery: f32,
    /// Joint positions, `[J]` (rad).
    pub position: Vec<f32>,
    /// Joint velocities, `[J]` (rad/s).
    pub velocity: Vec<f32>,
    /// Joint torques, `[J]` (N m); NaN where they are not measured.
    pub torque: Vec<f32>,
    /// Motor temperatures, `[J]` (degrees Celsius); NaN where they are not measured.
    pub temperature: Vec<f32>,
    /// Root state from outside, where there is one.
    pub external: Option<External>,
}

impl Measurement {
    /// A robot at rest in its zero pose.
    pub fn new(joints: usize) -> Self {
        Self {
            sequence: 0,
            clock: 0,
            stop: false,
            orientation: [1.0, 0.0, 0.0, 0.0],
            gyroscope_b: [0.0; 3],
            accelerometer_b: [f32::NAN; 3],
            battery: f32::NAN,
            position: vec![0.0; joints],
            velocity: vec![0.0; joints],
            torque: vec![f32::NAN; joints],
            temperature: vec![f32::NAN; joints],
            external: None,
        }
    }

    /// Copies another measurement of the same robot without allocating.
    ///
    /// # Panics
    /// The other one has another number of joints.
    pub fn copy_from(&mut self, other: &Self) {
        self.position.copy_from_slice(&other.position);
        self.velocity.copy_from_slice(&other.velocity);
        self.torque.copy_from_slice(&other.torque);
        self.temperature.copy_from_slice(&other.temperature);
        let Self { sequence, clock, stop, orientation, gyroscope_b, accelerometer_b, battery, external, .. } = *other;
        (self.sequence, self.clock, self.stop) = (sequence, clock, stop);
        (self.orientation, self.gyroscope_b, self.accelerometer_b) = (orientation, gyroscope_b, accelerometer_b);
        (self.battery, self.external) = (battery, external);
    }

    /// Returns the first number that is needed and not finite: its name and joint.
    pub(crate) fn non_finite(&self) -> Option<(&'static str, usize)> {
        let joint = |values: &[f32]| values.iter().position(|x| !x.is_finite());
        let norm: f32 = self.orientation.iter().map(|x| x * x).sum();
        let outside = self.external.is_some_and(|External { position, linear_velocity_w }| {
            position.iter().chain(&linear_velocity_w).any(|x| !x.is_finite())
        });
        if !(0.9..1.1).contains(&norm) {
            Some(("orientation", 0))
        } else if self.gyroscope_b.iter().any(|x| !x.is_finite()) {
            Some(("gyroscope", 0))
        } else if outside {
            Some(("external root state", 0))
        } else {
            joint(&self.position).map(|j| ("position", j)).or_else(|| joint(&self.velocity).map(|j| ("velocity", j)))
        }
    }
}

/// Everything that a machine says about itself before the first command.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// Name of the robot.
    pub robot: String,
    /// SHA-256 of the robot's description ([`lifelike_robot::controller::RobotDescription::digest`]); empty where unknown.
    pub digest: String,
    /// Joint names in the order of its packets.
    pub joints: Vec<String>,
    /// Motors that answer.
    pub motors: usize,
    /// Control mode: `position` (targets with gains), or another that the runtime refuses.
    pub mode: String,
    /// Packets with measurements per second (Hz).
    pub state_hz: f64,
    /// Most commands per second (Hz).
    pub command_hz_max: f64,
    /// Proportional gains that it is set up for, `[J]` (N m/rad).
    pub kp: Vec<f64>,
    /// Derivative gains that it is set up for, `[J]` (N m s/rad).
    pub kd: Vec<f64>,
    /// Largest torques, `[J]` (N m).
    pub torque_max: Vec<f64>,
    /// Least and greatest positions, `[J]` (rad); none for a joint without limits.
    pub range: Vec<Option<(f64, f64)>>,
    /// Orientation of the IMU in the root (`wxyz`).
    pub imu_orientation: [f64; 4],
}

impl Facts {
    /// Describes a robot as its own machine would.
    pub fn of(robot: &lifelike_robot::Robot, state_hz: f64, command_hz_max: f64) -> Self {
        let parameters = &robot.actuators.parameters;
        Self {
            robot: robot.name.clone(),
            digest: lifelike_robot::controller::RobotDescription::of(robot).digest,
            joints: robot.layout.joints.clone(),
            motors: robot.joints(),
            mode: "position".into(),
            state_hz,
            command_hz_max,
            kp: parameters.iter().map(|p| p.kp).collect(),
            kd: parameters.iter().map(|p| p.kd).collect(),
            torque_max: parameters.iter().map(|p| p.torque_max).collect(),
            range: robot.character.scalar_joints().map(|joint| joint.range).collect(),
            imu_orientation: [1.0, 0.0, 0.0, 0.0],
        }
    }
}
