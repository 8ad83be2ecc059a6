//! Checks of every servo before the first command.

use std::time::{Duration, Instant};

use lifelike_robot::Robot;
use lifelike_runtime::{Facts, RuntimeError, ThreadedBus};

use crate::bus::Chain;
use crate::imu::Imu;
use crate::line::Line;
use crate::model::{Model, address, hardware_errors};
use crate::packet::Instruction;
use crate::servos::{OperatingMode, Servo, ServoFile};

/// Time in which cycles are counted.
const COUNTING: Duration = Duration::from_millis(500);
/// Angle by which a joint may be beyond its range before the first command (rad).
const BEYOND: f64 = 0.35;
/// Positions of current-based position mode, 256 turns to each side.
const TURNS: (i32, i32) = (-1_048_575, 1_048_575);

/// Address of a robot of servos.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DynamixelOptions {
    /// Serial port, such as `/dev/ttyUSB0`.
    pub port: String,
    /// Address `HOST:PORT` on which packets of the IMU arrive; empty: none.
    pub imu: String,
}

/// Connects to a robot of servos, and describes it for the handshake. Commands come at `command_hz` (Hz).
///
/// Motors are turned off first. Then each servo's model, hardware errors and position are checked; its mode, gains and watchdog are
/// written. Stiffness, damping and torque of the facts are those of the file: servos do not say them.
///
/// # Errors
/// The port does not open; joints and servos differ; a floating base has no IMU. A servo is silent, of another model, defective, or out
/// of its joint's range.
pub fn dynamixel(
    options: &DynamixelOptions,
    file: &ServoFile,
    robot: &Robot,
    command_hz: f64,
) -> Result<ThreadedBus, RuntimeError> {
    let bus = format!("dynamixel:{}", options.port);
    let fails = |expected: &str, got: String| RuntimeError::Bus { bus: bus.clone(), expected: expected.into(), got };
    let servos = file.in_order(robot)?;
    let imu = match options.imu.as_str() {
        "" if robot.character.root_joint().is_some() => {
            let expected = "imu=HOST:PORT: the gate compares the root's tilt, and servos measure none";
            return Err(fails(expected, "no imu".into()));
        }
        "" => None,
        address => Some(Imu::listen(&bus, address)?),
    };
    let opened = Line::open(&options.port, file.baud);
    let mut line =
        opened.map_err(|error| fails("a serial port (is it there, and may you use it?)", error.to_string()))?;
    let broken = |error: std::io::Error| fails("answers of the servos", error.to_string());
    let mut lines = Vec::new();
    let mut limits = Vec::new();
    for (servo, joint) in servos.iter().zip(robot.character.scalar_joints()) {
        match set_up(&mut line, servo, file.baud, joint.range).map_err(broken)? {
            Ok(limit) => limits.push(limit),
            Err(difference) => lines.push(format!("{}: {difference}", servo.words())),
        }
    }
    if !lines.is_empty() {
        return Err(RuntimeError::Refused(lines.join("\n  ")));
    }
    let fixed = robot.character.fixed_base().map(|(_, q)| [q.w, q.i, q.j, q.k].map(|x| x as f32));
    let mut chain = Chain::new(line, servos.clone(), limits.clone(), imu, fixed, command_hz);
    let (begin, mut cycles) = (Instant::now(), 0u32);
    while begin.elapsed() < COUNTING {
        cycles += u32::from(chain.cycle().map_err(broken)?);
    }
    let rate = (f64::from(cycles) / begin.elapsed().as_secs_f64()).min(command_hz);
    let mut facts = Facts::of(robot, rate, 1.0 / file.cycle().as_secs_f64());
    facts.kp = servos.iter().map(|servo| servo.kp).collect();
    facts.kd = servos.iter().map(|servo| servo.kd).collect();
    facts.torque_max = servos.iter().map(|servo| servo.torque_max).collect();
    for ((range, servo), limits) in facts.range.iter_mut().zip(&servos).zip(&limits) {
        let (a, b) = (servo.angle(limits.0), servo.angle(limits.1));
        let (low, high) = (a.min(b), a.max(b));
        // A servo that reaches all of the joint's range is as good as the joint.
        if range.is_some_and(|(least, most)| low > least || high < most) {
            *range = Some((low, high));
        }
    }
    Ok(ThreadedBus::start(facts, chain))
}

/// Checks one servo and writes its settings; returns the positions that it accepts, or a sentence about what differs.
fn set_up(
    line: &mut Line,
    servo: &Servo,
    baud: u32,
    range: Option<(f64, f64)>,
) -> std::io::Result<Result<(i32, i32), String>> {
    let Some(answer) = line.ask(servo.id, Instruction::Ping, &[])? else {
        return Ok(Err(format!(
            "expected an answer at {baud} bits/s, got none: check power, wiring, id and baud rate"
        )));
    };
    let number = answer.get(1..3).map_or(0, |bytes| u16::from_le_bytes([bytes[0], bytes[1]]));
    let Some(model) = Model::by_name(&servo.model).filter(|model| model.number == number) else {
        let expected = Model::by_name(&servo.model).map_or(String::new(), |model| Model::words(model.number));
        return Ok(Err(format!("expected {expected}, got {}: are ids exchanged?", Model::words(number))));
    };
    let silent = || Ok(Err("expected answers to every request, got silence or a refusal".to_string()));
    let Some(errors) = line.read(servo.id, address::HARDWARE_ERROR, 1)? else { return silent() };
    if errors[0] != 0 {
        let got = hardware_errors(errors[0]);
        return Ok(Err(format!("expected no hardware error, got {got}: repair the cause, turn power off and on")));
    }
    let mut present = [0; 10];
    match line.read(servo.id, address::PRESENT, 10)? {
        Some(bytes) => present.copy_from_slice(&bytes),
        None => return silent(),
    }
    let position = i32::from_le_bytes([present[6], present[7], present[8], present[9]]);
    let angle = servo.angle(position);
    if let Some((low, high)) = range.filter(|(low, high)| !(low - BEYOND..=high + BEYOND).contains(&angle)) {
        return Ok(Err(format!(
            "expected its joint at {low:.3} to {high:.3} rad, got {angle:.3}: check id, sign and zero_offset"
        )));
    }
    let current = match (model.current_unit, servo.current_max) {
        (Some(unit), Some(current)) => (current / unit).round() as i16,
        _ => 0,
    };
    let [d, p] = [servo.d_gain, servo.p_gain].map(u16::to_le_bytes);
    let writes: [(u16, &[u8]); 7] = [
        // A watchdog that has stopped a servo refuses goals until it is cleared.
        (address::BUS_WATCHDOG, &[0]),
        (address::TORQUE_ENABLE, &[0]),
        (address::OPERATING_MODE, &[servo.mode as u8]),
        (address::RETURN_DELAY, &[0]),
        (address::PROFILE, &[0; 8]),
        (address::POSITION_GAINS, &[d[0], d[1], 0, 0, p[0], p[1]]),
        (address::GOAL_CURRENT, &current.to_le_bytes()),
    ];
    for (to, value) in writes {
        if to == address::GOAL_CURRENT && servo.mode == OperatingMode::Position {
            continue;
        }
        // Settings that are kept without power wear out: they are written where they differ only.
        let is_kept = to == address::OPERATING_MODE || to == address::RETURN_DELAY;
        if is_kept && line.read(servo.id, to, value.len() as u16)?.is_some_and(|own| own == value) {
            continue;
        }
        if !line.write(servo.id, to, value)? {
            return Ok(Err(format!("expected it to take {value:?} at address {to}, got a refusal or silence")));
        }
    }
    if servo.mode == OperatingMode::CurrentBasedPosition {
        return Ok(Ok(TURNS));
    }
    let Some(limits) = line.read(servo.id, address::POSITION_LIMITS, 8)? else { return silent() };
    let number = |i: usize| i32::from_le_bytes([limits[i], limits[i + 1], limits[i + 2], limits[i + 3]]);
    let (least, most) = (number(4), number(0));
    if least > most {
        return Ok(Err(format!("expected a greatest position limit of at least the least ({least}), got {most}")));
    }
    Ok(Ok((least, most)))
}
