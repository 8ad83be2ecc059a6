//! From and to the runtime, by joint names.

use lifelike_runtime::udp::packet::Received;
use lifelike_runtime::{Measurement, Mode};

use crate::messages::{LowCmd, LowState, MotorCmd};

/// Names of the G1's 29 motors by their number, as its MJCF calls the joints.
pub const G1_MOTORS: [&str; 29] = [
    "left_hip_pitch_joint",
    "left_hip_roll_joint",
    "left_hip_yaw_joint",
    "left_knee_joint",
    "left_ankle_pitch_joint",
    "left_ankle_roll_joint",
    "right_hip_pitch_joint",
    "right_hip_roll_joint",
    "right_hip_yaw_joint",
    "right_knee_joint",
    "right_ankle_pitch_joint",
    "right_ankle_roll_joint",
    "waist_yaw_joint",
    "waist_roll_joint",
    "waist_pitch_joint",
    "left_shoulder_pitch_joint",
    "left_shoulder_roll_joint",
    "left_shoulder_yaw_joint",
    "left_elbow_joint",
    "left_wrist_roll_joint",
    "left_wrist_pitch_joint",
    "left_wrist_yaw_joint",
    "right_shoulder_pitch_joint",
    "right_shoulder_roll_joint",
    "right_shoulder_yaw_joint",
    "right_elbow_joint",
    "right_wrist_roll_joint",
    "right_wrist_pitch_joint",
    "right_wrist_yaw_joint",
];

/// Buttons of the remote, in its bytes 2 and 3.
const REMOTE_L2: u8 = 1 << 5;
const REMOTE_B: u8 = 1 << 1;

/// Motor of each joint of a robot, in the robot's order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Motors(Vec<usize>);

/// A joint that no motor has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MotorsError {
    /// Name of the joint.
    pub joint: String,
}

impl std::fmt::Display for MotorsError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "joint '{}': expected a joint of the G1 such as '{}', got no motor", self.joint, G1_MOTORS[0])
    }
}

impl std::error::Error for MotorsError {}

impl Motors {
    /// Finds the motors of joints by name, in any order: a robot may have fewer than all.
    ///
    /// # Errors
    /// A joint that no motor has.
    pub fn of(joints: &[String]) -> Result<Self, MotorsError> {
        let find = |joint: &String| G1_MOTORS.iter().position(|motor| motor == joint);
        let motors = joints.iter().map(|joint| find(joint).ok_or_else(|| MotorsError { joint: joint.clone() }));
        motors.collect::<Result<Vec<_>, _>>().map(Self)
    }

    /// Returns the number of motors that report no error.
    pub fn healthy(&self, state: &LowState) -> usize {
        self.0.iter().filter(|motor| state.motor_state[**motor].motorstate == 0).count()
    }
}

/// Writes a command that passed the gate; `mode_machine` is that of the last state. Motors of no joint are disabled.
pub fn command(safe: &Received, motors: &Motors, mode_machine: u8, out: &mut LowCmd) {
    *out = LowCmd { mode_machine, ..LowCmd::default() };
    let mode = u8::from(safe.mode != Mode::Off);
    for (j, &motor) in motors.0.iter().enumerate() {
        let (q, kp, kd) = (safe.position[j], safe.kp[j], safe.kd[j]);
        out.motor_cmd[motor] = MotorCmd { mode, q, kp, kd, ..MotorCmd::default() };
    }
}

/// Writes a state as a measurement: its count of milliseconds is its clock, and over `tick_step` its sequence. The warmer of a
/// motor's two temperatures counts; the battery's voltage is the mean of the motors'. L2 and B of the remote are the stop button.
///
/// # Panics
/// `into` has another number of joints than `motors`.
pub fn measure(state: &LowState, motors: &Motors, tick_step: u32, into: &mut Measurement) {
    into.sequence = state.tick / tick_step.max(1);
    into.clock = u64::from(state.tick) * 1_000_000;
    into.orientation = state.imu_state.quaternion;
    into.gyroscope_b = state.imu_state.gyroscope;
    into.accelerometer_b = state.imu_state.accelerometer;
    let [.., first, second] = [0, 1, 2, 3].map(|i| state.wireless_remote[i]);
    into.stop = first & REMOTE_L2 != 0 && second & REMOTE_B != 0;
    into.external = None;
    let mut voltage = 0.0;
    for (j, &motor) in motors.0.iter().enumerate() {
        let from = &state.motor_state[motor];
        (into.position[j], into.velocity[j], into.torque[j]) = (from.q, from.dq, from.tau_est);
        into.temperature[j] = f32::from(from.temperature[0].max(from.temperature[1]));
        voltage += from.vol;
    }
    into.battery = voltage / motors.0.len().max(1) as f32;
}
