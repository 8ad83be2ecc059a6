//! The messages, field by field as Unitree names them.

use crate::crc::Crc;
use lifelike_cdr::{Reader, Writer};

/// Motors in a message, in use or not.
pub const MOTORS: usize = 35;

/// Command of one motor.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotorCmd {
    /// 1: enabled.
    pub mode: u8,
    /// Target (rad).
    pub q: f32,
    /// Target velocity (rad/s).
    pub dq: f32,
    /// Torque beside the gains' (N m).
    pub tau: f32,
    /// Proportional gain (N m/rad).
    pub kp: f32,
    /// Derivative gain (N m s/rad).
    pub kd: f32,
    /// Not used.
    pub reserve: u32,
}

/// Commands of all motors: topic `rt/lowcmd`.
#[derive(Debug, Clone, PartialEq)]
pub struct LowCmd {
    /// Ankles and waist: 0 by pitch and roll, 1 by the motors A and B.
    pub mode_pr: u8,
    /// Kind of the machine, as the last state says.
    pub mode_machine: u8,
    /// The motors.
    pub motor_cmd: [MotorCmd; MOTORS],
    /// Not used.
    pub reserve: [u32; 4],
}

/// State of one motor.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotorState {
    /// 1: enabled.
    pub mode: u8,
    /// Position (rad).
    pub q: f32,
    /// Velocity (rad/s).
    pub dq: f32,
    /// Acceleration (rad/s²).
    pub ddq: f32,
    /// Estimated torque (N m).
    pub tau_est: f32,
    /// Temperatures of surface and winding (degrees Celsius).
    pub temperature: [i16; 2],
    /// Voltage (V).
    pub vol: f32,
    /// Sensors.
    pub sensor: [u32; 2],
    /// Errors, a bit each.
    pub motorstate: u32,
    /// Not used.
    pub reserve: [u32; 4],
}

/// State of the IMU.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ImuState {
    /// Orientation (`wxyz`).
    pub quaternion: [f32; 4],
    /// Angular velocity (rad/s).
    pub gyroscope: [f32; 3],
    /// Acceleration (m/s²).
    pub accelerometer: [f32; 3],
    /// Roll, pitch and yaw (rad).
    pub rpy: [f32; 3],
    /// Temperature (degrees Celsius).
    pub temperature: i16,
}

/// State of the robot: topic `rt/lowstate`.
#[derive(Debug, Clone, PartialEq)]
pub struct LowState {
    /// Versions.
    pub version: [u32; 2],
    /// As in [`LowCmd`].
    pub mode_pr: u8,
    /// Kind of the machine.
    pub mode_machine: u8,
    /// Count of the controller (ms).
    pub tick: u32,
    /// The IMU.
    pub imu_state: ImuState,
    /// The motors.
    pub motor_state: [MotorState; MOTORS],
    /// Buttons and sticks.
    pub wireless_remote: [u8; 40],
    /// Not used.
    pub reserve: [u32; 4],
}

/// A message that cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MessageError {
    /// The header is not that of little-endian CDR, or the message is too short or too long.
    Layout,
    /// The checksum is another.
    Checksum {
        /// Checksum of the content.
        expected: u32,
        /// Checksum in the message.
        got: u32,
    },
}

impl std::fmt::Display for MessageError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Layout => f.write_str("expected a whole HG message in little-endian CDR, got another layout"),
            Self::Checksum { expected, got } => write!(f, "checksum: expected {expected:#010x}, got {got:#010x}"),
        }
    }
}

impl std::error::Error for MessageError {}

impl Default for LowCmd {
    fn default() -> Self {
        Self { mode_pr: 0, mode_machine: 0, motor_cmd: [MotorCmd::default(); MOTORS], reserve: [0; 4] }
    }
}

impl LowCmd {
    /// Returns the checksum.
    pub fn crc(&self) -> u32 {
        let mut crc = Crc::new();
        crc.word(u32::from_le_bytes([self.mode_pr, self.mode_machine, 0, 0]));
        for motor in &self.motor_cmd {
            crc.word(motor.mode.into());
            [motor.q, motor.dq, motor.tau, motor.kp, motor.kd].iter().for_each(|x| crc.number(*x));
            crc.word(motor.reserve);
        }
        self.reserve.iter().for_each(|word| crc.word(*word));
        crc.value()
    }

    /// Writes the message with its checksum. Allocates nothing when `out` has room.
    pub fn write(&self, out: &mut Vec<u8>) {
        let mut to = Writer::begin(out);
        to.all(&[self.mode_pr, self.mode_machine]);
        for motor in &self.motor_cmd {
            to.put(motor.mode);
            to.all(&[motor.q, motor.dq, motor.tau, motor.kp, motor.kd]);
            to.put(motor.reserve);
        }
        to.all(&self.reserve);
        to.put(self.crc());
    }

    /// Reads a message.
    ///
    /// # Errors
    /// The layout or the checksum is another.
    pub fn read(bytes: &[u8]) -> Result<Self, MessageError> {
        let (message, crc) = Self::parse(bytes).ok_or(MessageError::Layout)?;
        checked(message.crc(), crc).map(|()| message)
    }

    fn parse(bytes: &[u8]) -> Option<(Self, u32)> {
        let mut from = Reader::begin(bytes)?;
        let mut message = Self { mode_pr: from.get()?, mode_machine: from.get()?, ..Self::default() };
        for motor in &mut message.motor_cmd {
            let mode = from.get()?;
            let [q, dq, tau, kp, kd] = from.all()?;
            *motor = MotorCmd { mode, q, dq, tau, kp, kd, reserve: from.get()? };
        }
        message.reserve = from.all()?;
        let crc = from.get()?;
        (from.read() == bytes.len()).then_some((message, crc))
    }
}

impl Default for LowState {
    fn default() -> Self {
        Self {
            version: [0; 2],
            mode_pr: 0,
            mode_machine: 0,
            tick: 0,
            imu_state: ImuState::default(),
            motor_state: [MotorState::default(); MOTORS],
            wireless_remote: [0; 40],
            reserve: [0; 4],
        }
    }
}

impl LowState {
    /// Returns the checksum.
    pub fn crc(&self) -> u32 {
        let mut crc = Crc::new();
        self.version.iter().for_each(|word| crc.word(*word));
        crc.word(u32::from_le_bytes([self.mode_pr, self.mode_machine, 0, 0]));
        crc.word(self.tick);
        let imu = &self.imu_state;
        imu.quaternion.iter().for_each(|x| crc.number(*x));
        [imu.gyroscope, imu.accelerometer, imu.rpy].iter().flatten().for_each(|x| crc.number(*x));
        crc.word(u32::from(imu.temperature as u16));
        for motor in &self.motor_state {
            crc.word(motor.mode.into());
            [motor.q, motor.dq, motor.ddq, motor.tau_est].iter().for_each(|x| crc.number(*x));
            let [surface, winding] = motor.temperature.map(|t| u32::from(t as u16));
            crc.word(surface | winding << 16);
            crc.number(motor.vol);
            motor.sensor.iter().for_each(|word| crc.word(*word));
            crc.word(motor.motorstate);
            motor.reserve.iter().for_each(|word| crc.word(*word));
        }
        self.wireless_remote.as_chunks::<4>().0.iter().for_each(|word| crc.word(u32::from_le_bytes(*word)));
        self.reserve.iter().for_each(|word| crc.word(*word));
        crc.value()
    }

    /// Writes the message with its checksum. Allocates nothing when `out` has room.
    pub fn write(&self, out: &mut Vec<u8>) {
        let mut to = Writer::begin(out);
        to.all(&self.version);
        to.all(&[self.mode_pr, self.mode_machine]);
        to.put(self.tick);
        let imu = &self.imu_state;
        to.all(&imu.quaternion);
        to.all(&imu.gyroscope);
        to.all(&imu.accelerometer);
        to.all(&imu.rpy);
        to.put(imu.temperature);
        for motor in &self.motor_state {
            to.put(motor.mode);
            to.all(&[motor.q, motor.dq, motor.ddq, motor.tau_est]);
            to.all(&motor.temperature);
            to.put(motor.vol);
            to.all(&motor.sensor);
            to.put(motor.motorstate);
            to.all(&motor.reserve);
        }
        to.all(&self.wireless_remote);
        to.all(&self.reserve);
        to.put(self.crc());
    }

    /// Reads a message.
    ///
    /// # Errors
    /// The layout or the checksum is another.
    pub fn read(bytes: &[u8]) -> Result<Self, MessageError> {
        let (message, crc) = Self::parse(bytes).ok_or(MessageError::Layout)?;
        checked(message.crc(), crc).map(|()| message)
    }

    fn parse(bytes: &[u8]) -> Option<(Self, u32)> {
        let mut from = Reader::begin(bytes)?;
        let mut message = Self {
            version: from.all()?,
            mode_pr: from.get()?,
            mode_machine: from.get()?,
            tick: from.get()?,
            imu_state: ImuState {
                quaternion: from.all()?,
                gyroscope: from.all()?,
                accelerometer: from.all()?,
                rpy: from.all()?,
                temperature: from.get()?,
            },
            ..Self::default()
        };
        for motor in &mut message.motor_state {
            let mode = from.get()?;
            let [q, dq, ddq, tau_est] = from.all()?;
            let (temperature, vol) = (from.all()?, from.get()?);
            let (sensor, motorstate, reserve) = (from.all()?, from.get()?, from.all()?);
            *motor = MotorState { mode, q, dq, ddq, tau_est, temperature, vol, sensor, motorstate, reserve };
        }
        message.wireless_remote = from.all()?;
        message.reserve = from.all()?;
        let crc = from.get()?;
        (from.read() == bytes.len()).then_some((message, crc))
    }
}

fn checked(expected: u32, got: u32) -> Result<(), MessageError> {
    if expected == got { Ok(()) } else { Err(MessageError::Checksum { expected, got }) }
}
