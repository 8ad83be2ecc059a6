//! The file of a robot's servos (TOML).

use std::path::Path;
use std::time::Duration;

use lifelike_robot::Robot;
use lifelike_runtime::{FromInput, RuntimeError};

use crate::line::wire_time;
use crate::model::{CENTRE, Model, POSITION_UNIT};

/// Bytes of a cycle without servos, and for each of them: positions out, then current, velocity and position in.
const CYCLE_BYTES: usize = 28;
const SERVO_BYTES: usize = 27;
/// Delay of the adapter in each cycle: the shortest latency timer of the FTDI chip in ROBOTIS' U2D2.
const ADAPTER: Duration = Duration::from_millis(1);
/// Most commands per second that follow by default (Hz).
const COMMAND_HZ: f64 = 1000.0;

/// Servos of a robot on one port.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ServoFile {
    /// Baud rate of port and servos (bits/s).
    pub baud: u32,
    /// Servos, one for each joint of the robot, in any order.
    pub servo: Vec<Servo>,
}

/// One servo and its joint.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Servo {
    /// Name of the joint.
    pub joint: String,
    /// Identifier on the bus, 0 to 252.
    pub id: u8,
    /// Model, such as `XM430-W350`, without the letter of the wiring.
    pub model: String,
    /// Direction: 1, or -1 where the joint turns against the servo.
    #[serde(default = "one")]
    pub sign: i8,
    /// Joint position where the servo reads 2048 (rad).
    #[serde(default)]
    pub zero_offset: f64,
    /// Operating mode.
    pub mode: OperatingMode,
    /// Position P gain of the firmware, 0 to 16383 (no unit).
    pub p_gain: u16,
    /// Position D gain of the firmware, 0 to 16383 (no unit).
    pub d_gain: u16,
    /// Stiffness that `p_gain` gives, as measured (N m/rad).
    pub kp: f64,
    /// Damping that `d_gain` and the motor give, as measured (N m s/rad).
    pub kd: f64,
    /// Largest torque (N m).
    pub torque_max: f64,
    /// Largest current of `current_based_position` (A).
    pub current_max: Option<f64>,
    /// Torque for a current (N m/A); without it torques count as not measured.
    pub torque_constant: Option<f64>,
}

fn one() -> i8 {
    1
}

/// Operating mode of a servo's firmware.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
#[repr(u8)]
pub enum OperatingMode {
    /// Position within a turn, limited by the duty of the motor.
    Position = 3,
    /// Position, limited by `current_max`.
    CurrentBasedPosition = 5,
}

impl ServoFile {
    /// Reads a file.
    ///
    /// # Errors
    /// It cannot be read; an unknown key, a wrong type or a number out of range.
    pub fn read(path: &Path) -> Result<Self, RuntimeError> {
        let text = std::fs::read_to_string(path).map_err(RuntimeError::io(path))?;
        Self::from_toml(&text, &path.display().to_string())
    }

    /// Reads the text of a file, whose name stands in errors.
    ///
    /// # Errors
    /// An unknown key, a wrong type or a number out of range.
    pub fn from_toml(text: &str, name: &str) -> Result<Self, RuntimeError> {
        let file: Self = toml::from_str(text).map_err(|error| {
            let line = error.span().map_or(1, |span| 1 + text[..span.start.min(text.len())].matches('\n').count());
            RuntimeError::mismatch(
                format!("{name}:{line}"),
                "TOML with baud and [[servo]] (docs/runtime.md)",
                error.message(),
            )
        })?;
        file.check(name)?;
        Ok(file)
    }

    fn check(&self, name: &str) -> Result<(), RuntimeError> {
        for (i, servo) in self.servo.iter().enumerate() {
            let key = |key: &str| format!("{name}: servo of joint '{}': {key}", servo.joint);
            let models = || Model::ALL.map(|model| model.name).join(", ");
            let model = Model::by_name(&servo.model)
                .ok_or_else(|| RuntimeError::mismatch(key("model"), format!("one of {}", models()), &servo.model))?;
            if self.baud < 9600 || self.baud > model.baud_max {
                let expected = format!("9600 to {} bits/s for {}", model.baud_max, model.name);
                return Err(RuntimeError::mismatch(format!("{name}: baud"), expected, self.baud));
            }
            if servo.id > 252 {
                return Err(RuntimeError::mismatch(key("id"), "0 to 252", servo.id));
            }
            if let Some(other) = self.servo[..i].iter().find(|other| other.id == servo.id || other.joint == servo.joint)
            {
                let what = if other.id == servo.id { "id" } else { "joint" };
                let expected = format!("{what} of one servo only");
                let got = format!("that of joint '{}' again", other.joint);
                return Err(RuntimeError::mismatch(key(what), expected, got));
            }
            if servo.sign.abs() != 1 {
                return Err(RuntimeError::mismatch(key("sign"), "1 or -1", servo.sign));
            }
            for (what, gain) in [("p_gain", servo.p_gain), ("d_gain", servo.d_gain)] {
                if gain > 16_383 {
                    return Err(RuntimeError::mismatch(key(what), "0 to 16383", gain));
                }
            }
            let numbers = [
                ("zero_offset", Some(servo.zero_offset), -10.0, 10.0, "rad"),
                ("kp", Some(servo.kp), 1e-6, 1e6, "N m/rad"),
                ("kd", Some(servo.kd), 0.0, 1e6, "N m s/rad"),
                ("torque_max", Some(servo.torque_max), 1e-6, 1e6, "N m"),
                ("torque_constant", servo.torque_constant, 1e-6, 1e3, "N m/A"),
                ("current_max", servo.current_max, 1e-3, 30.0, "A"),
            ];
            for (what, value, low, high, unit) in numbers {
                if let Some(value) = value.filter(|value| !(low..=high).contains(value)) {
                    return Err(RuntimeError::mismatch(key(what), format!("{low} to {high} {unit}"), value));
                }
            }
            let is_limited = servo.mode == OperatingMode::CurrentBasedPosition;
            if is_limited && model.current_unit.is_none() {
                let expected = format!("position: {} measures no current", model.name);
                return Err(RuntimeError::mismatch(key("mode"), expected, "current_based_position"));
            }
            if is_limited != servo.current_max.is_some() {
                let expected = if is_limited { "a current (A) in current_based_position" } else { "none in position" };
                let got = servo.current_max.map_or("none".into(), |current| format!("{current} A"));
                return Err(RuntimeError::mismatch(key("current_max"), expected, got));
            }
            if model.current_unit.is_none() && servo.torque_constant.is_some() {
                let expected = format!("none: {} measures no current", model.name);
                let got = servo.torque_constant.unwrap_or_default();
                return Err(RuntimeError::mismatch(key("torque_constant"), expected, got));
            }
        }
        Ok(())
    }

    /// Returns the time of the bytes of one cycle: a command to all servos, and their answers.
    pub fn cycle(&self) -> Duration {
        wire_time(CYCLE_BYTES + SERVO_BYTES * self.servo.len(), self.baud)
    }

    /// Returns the rate of commands that follows from the bytes of a cycle and the adapter's delay (Hz): a multiple of the policy's.
    pub fn command_hz(&self, control_hz: f64) -> f64 {
        let rate = (1.0 / (self.cycle() + ADAPTER).as_secs_f64()).min(COMMAND_HZ);
        control_hz * (rate / control_hz).floor().max(1.0)
    }

    /// Returns the servos in the order of a robot's joints.
    ///
    /// # Errors
    /// [`RuntimeError::Refused`]: a joint has no servo, or a servo has no joint.
    pub(crate) fn in_order(&self, robot: &Robot) -> Result<Vec<Servo>, RuntimeError> {
        let joints = &robot.layout.joints;
        let find = |joint: &String| self.servo.iter().find(|servo| servo.joint == *joint);
        let missing = joints.iter().filter(|joint| find(joint).is_none());
        let lost = self.servo.iter().filter(|servo| !joints.contains(&servo.joint));
        let lines: Vec<String> = missing
            .map(|joint| format!("joint '{joint}': expected a servo, got none"))
            .chain(lost.map(|servo| {
                format!("servo {}: expected a joint of '{}', got '{}'", servo.id, robot.name, servo.joint)
            }))
            .collect();
        if lines.is_empty() {
            Ok(joints.iter().filter_map(find).cloned().collect())
        } else {
            Err(RuntimeError::Refused(lines.join("\n  ")))
        }
    }
}

impl Servo {
    /// Returns the joint's position where the servo reads `units` (rad).
    pub(crate) fn angle(&self, units: i32) -> f64 {
        self.zero_offset + f64::from(self.sign) * f64::from(units.saturating_sub(CENTRE)) * POSITION_UNIT
    }

    /// Returns the servo's reading where the joint is at `angle` (rad).
    pub(crate) fn units(&self, angle: f64) -> i32 {
        CENTRE.saturating_add((f64::from(self.sign) * (angle - self.zero_offset) / POSITION_UNIT).round() as i32)
    }

    /// Returns the servo in words.
    pub(crate) fn words(&self) -> String {
        format!("servo {} (joint '{}')", self.id, self.joint)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::packet::{Instruction, sync_read, sync_write, write_packet};

    const GOOD: &str = "baud = 4000000\n[[servo]]\njoint = 'knee'\nid = 3\nmodel = 'XM430-W350'\nsign = -1\nzero_offset = 0.5\n\
        mode = 'current_based_position'\np_gain = 800\nd_gain = 0\nkp = 12.0\nkd = 0.5\ntorque_max = 4.1\ncurrent_max = 2.3\n";

    fn many(count: usize, baud: u32) -> ServoFile {
        let one = ServoFile::from_toml(GOOD, "servos.toml").unwrap().servo.remove(0);
        let servo = (0..count).map(|i| Servo { id: i as u8, joint: format!("joint {i}"), ..one.clone() }).collect();
        ServoFile { baud, servo }
    }

    #[test]
    fn angles_are_those_of_a_turn_of_4096() {
        let servo = &ServoFile::from_toml(GOOD, "servos.toml").unwrap().servo[0];
        assert!((servo.angle(2048 + 1024) - (0.5 - std::f64::consts::FRAC_PI_2)).abs() < 1e-12);
        assert_eq!((servo.units(0.5), servo.units(0.5 + std::f64::consts::FRAC_PI_2)), (2048, 1024));
        (0..4096).for_each(|units| assert_eq!(servo.units(servo.angle(units)), units));
    }

    #[test]
    fn wrong_keys_are_refused_by_name() {
        let servo = "servos.toml: servo of joint 'knee': ";
        for (from, to, part) in [
            ("id = 3", "id = 253", format!("{servo}id: expected 0 to 252, got 253")),
            ("XM430-W350", "AX-12", format!("{servo}model: expected one of XL330-M077")),
            ("sign = -1", "sign = 2", format!("{servo}sign: expected 1 or -1, got 2")),
            ("p_gain = 800", "p_gain = 20000", format!("{servo}p_gain: expected 0 to 16383, got 20000")),
            ("kp = 12.0", "kp = nan", format!("{servo}kp: expected 0.000001 to 1000000 N m/rad, got NaN")),
            ("current_max = 2.3", "", format!("{servo}current_max: expected a current (A)")),
            ("XM430-W350", "XL430-W250", format!("{servo}mode: expected position: XL430-W250 measures no current")),
            ("4000000", "5000000", "servos.toml: baud: expected 9600 to 4500000 bits/s for XM430-W350".into()),
            ("sign", "signs", "servos.toml:6: expected TOML with baud and [[servo]]".into()),
            ("id = 3", "id = 'three'", "servos.toml:4: expected TOML".into()),
        ] {
            let error = ServoFile::from_toml(&GOOD.replace(from, to), "servos.toml").unwrap_err().to_string();
            assert!(error.contains(&part), "{from} -> {to}: {error}");
        }
        let again = GOOD.split_once('\n').unwrap().1.replace("'knee'", "'hip'");
        let error = ServoFile::from_toml(&format!("{GOOD}{again}"), "servos.toml").unwrap_err().to_string();
        assert!(error.contains("'hip': id: expected id of one servo only, got that of joint 'knee' again"), "{error}");
    }

    #[test]
    fn a_cycle_has_the_bytes_of_its_packets() {
        for count in [1, 13, 36] {
            let ids: Vec<u8> = (0..count).collect();
            let (mut bytes, mut out) = (0, Vec::new());
            sync_write(116, ids.iter().map(|id| (*id, [0; 4])), &mut out);
            bytes += out.len();
            sync_read(126, 10, &ids, &mut out);
            bytes += out.len();
            write_packet(1, Instruction::Status, [0; 11], &mut out);
            bytes += out.len() * ids.len();
            assert_eq!(many(ids.len(), 4_000_000).cycle(), wire_time(bytes, 4_000_000));
        }
    }

    #[test]
    fn rates_follow_from_bytes() {
        let fits = |count, ms: u64| many(count, 4_000_000).cycle() <= Duration::from_micros(ms);
        assert!(fits(13, 1000) && !fits(14, 1000) && fits(36, 2500) && !fits(37, 2500));
        assert_eq!(many(20, 4_000_000).command_hz(50.0), 400.0);
        assert_eq!(many(20, 1_000_000).command_hz(50.0), 100.0);
        assert_eq!(many(20, 57_600).command_hz(50.0), 50.0, "never below the policy's: the handshake refuses it");
    }
}
