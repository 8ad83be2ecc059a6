//! Byte for byte against Unitree's published Python package (`peers/unitree/fixtures.py` wrote the files).
#![allow(clippy::unwrap_used)]

use lifelike_runtime::gate::{Gate, Intent, LimitSettings};
use lifelike_runtime::udp::packet::Received;
use lifelike_runtime::{Limits, Measurement, Mode};
use lifelike_unitree::{G1_MOTORS, LowCmd, LowState, MessageError, Motors, command, measure};

const LOW_CMD: &[u8] = include_bytes!("data/low_cmd.cdr");
const LOW_STATE: &[u8] = include_bytes!("data/low_state.cdr");

/// The numbers of the script.
fn numbers() -> impl FnMut() -> f32 {
    let mut i = 0;
    move || {
        i += 1;
        (i * 37 % 1009) as f32 / 8.0 - 60.0
    }
}

fn filled_command() -> LowCmd {
    let mut x = numbers();
    let mut message = LowCmd { mode_pr: 1, mode_machine: 5, reserve: [1, 2, 3, 4_000_000_000], ..LowCmd::default() };
    for (i, motor) in message.motor_cmd.iter_mut().enumerate() {
        motor.mode = (i % 2) as u8;
        (motor.q, motor.dq, motor.tau, motor.kp, motor.kd) = (x(), x(), x(), x(), x());
        motor.reserve = i as u32 * 1_000_003;
    }
    message
}

fn filled_state() -> LowState {
    let mut x = numbers();
    let mut message =
        LowState { version: [7, 8], mode_machine: 5, tick: 123_456_789, reserve: [9, 8, 7, 6], ..LowState::default() };
    let imu = &mut message.imu_state;
    imu.quaternion = [(); 4].map(|()| x());
    (imu.gyroscope, imu.accelerometer, imu.rpy) = ([(); 3].map(|()| x()), [(); 3].map(|()| x()), [(); 3].map(|()| x()));
    imu.temperature = -7;
    for (i, motor) in message.motor_state.iter_mut().enumerate() {
        let n = i as u32;
        motor.mode = (i % 2) as u8;
        (motor.q, motor.dq, motor.ddq, motor.tau_est) = (x(), x(), x(), x());
        (motor.temperature, motor.vol) = ([i as i16 - 5, 40 + i as i16], x());
        (motor.sensor, motor.motorstate, motor.reserve) = ([n, n + 1], 3 * n, [n, 0, 0, 4_000_000_000]);
    }
    message.wireless_remote = std::array::from_fn(|i| i as u8);
    message
}

#[test]
fn messages_are_those_of_the_package_byte_for_byte() {
    let mut bytes = Vec::new();
    filled_command().write(&mut bytes);
    assert_eq!(bytes, LOW_CMD);
    filled_state().write(&mut bytes);
    assert_eq!(bytes, LOW_STATE);
}

#[test]
fn messages_of_the_package_are_read() {
    assert_eq!(LowCmd::read(LOW_CMD).unwrap(), filled_command());
    assert_eq!(LowState::read(LOW_STATE).unwrap(), filled_state());
}

#[test]
fn damaged_messages_are_refused() {
    for length in 0..LOW_STATE.len() {
        assert_eq!(LowState::read(&LOW_STATE[..length]), Err(MessageError::Layout));
    }
    let mut longer = LOW_CMD.to_vec();
    longer.push(0);
    assert_eq!(LowCmd::read(&longer), Err(MessageError::Layout));
    // Bytes between numbers are not part of any: 1 behind the first motor's mode, 3 behind each other one's.
    let is_padding = |i: usize| i == 7 || (32..984).contains(&i) && matches!((i - 32) % 28, 1..4);
    for i in (4..LOW_CMD.len()).filter(|i| !is_padding(*i)) {
        let mut damaged = LOW_CMD.to_vec();
        damaged[i] ^= 0x10;
        let error = LowCmd::read(&damaged);
        assert!(matches!(error, Err(MessageError::Checksum { .. })), "byte {i}: {error:?}");
    }
}

#[test]
fn a_state_is_measured_and_a_command_is_sent_by_names() {
    let joints: Vec<String> = ["left_knee_joint", "waist_yaw_joint"].map(String::from).to_vec();
    let motors = Motors::of(&joints).unwrap();
    let mut measured = Measurement::new(2);
    let state = filled_state();
    measure(&state, &motors, 1, &mut measured);
    assert_eq!(measured.position, [state.motor_state[3].q, state.motor_state[12].q]);
    assert_eq!(measured.temperature, [43.0, 52.0], "the warmer of two");
    assert_eq!((measured.sequence, measured.clock), (123_456_789, 123_456_789_000_000));
    assert!(!measured.stop, "L1 and R1 are pressed in byte 2, A and B in byte 3");
    let mut pressed = state.clone();
    pressed.wireless_remote[2..4].copy_from_slice(&[0b10_0000, 0b10]);
    measure(&pressed, &motors, 2, &mut measured);
    assert!(measured.stop && measured.sequence == 61_728_394, "every second millisecond");
    assert_eq!((motors.healthy(&pressed), motors.healthy(&LowState::default())), (0, 2));
    let error = Motors::of(&["tail".to_string()]).unwrap_err().to_string();
    assert!(error.contains("joint 'tail'"), "{error}");

    // A gate of two of lima's joints stands for one of the G1's: the numbers come through.
    let robot = lifelike_robot::Robot::load("lima").unwrap();
    let mut limits = Limits::of(&robot, LimitSettings::default()).unwrap();
    limits.joints.truncate(2);
    let mut gate = Gate::new(limits, 500.0);
    measured = Measurement::new(2);
    for i in 0..6 {
        (measured.sequence, measured.clock) = (i, u64::from(i) * 2_000_000);
        gate.receive(measured.clock, &measured);
    }
    let intent = Intent { mode: Mode::Position, targets: &[0.1, 0.2], rate: 100.0, reference: &[], up_b: None };
    let mut low = LowCmd::default();
    let safe = gate.pass(12_000_000, intent);
    let mut sent = Received::new(2);
    sent.copy_from(safe);
    command(&sent, &motors, 5, &mut low);
    assert_eq!((low.mode_machine, low.motor_cmd[3].mode, low.motor_cmd[0].mode), (5, 1, 0));
    assert_eq!((low.motor_cmd[3].q, low.motor_cmd[12].kp), (safe.position()[0], safe.kp()[1]));
    assert_eq!(G1_MOTORS.len(), 29);
}
