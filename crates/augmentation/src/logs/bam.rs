//! Logs of BAM's test benches (github.com/Rhoban/bam): a servo that turns a weight on an arm, as JSON.
//!
//! A log is an object with `mass` (kg), `length` (m), `kp` (the servo's own unit), `vin` (V), `motor`, `trajectory`, and
//! `entries`: `timestamp` (s), `goal_position` and `position` (rad), `speed` (rad/s), `load` (the duty in 885ths, negative numbers
//! perhaps as unsigned 16 bits; 0 throughout where a servo does not tell it), `input_volts` (V), `torque_enable`.

use std::f64::consts::TAU;
use std::path::Path;

use lifelike_sim::bench::{BenchCommands, PendulumBench};
use lifelike_sim::trace::{BlockTrace, Columns, Trace};

use super::clock::Clock;
use crate::AugmentationError;

/// Units of a Dynamixel's duty of 1.
pub(crate) const DYNAMIXEL_DUTY_UNITS: f64 = 885.0;
/// No bench turns further (rad): what does is in degrees or ticks.
const FARTHEST: f64 = 4.0 * TAU;

/// What a bench's log says, at the times it was written.
#[derive(Debug, Clone, PartialEq)]
pub struct BenchLog {
    /// Name of the file.
    pub name: String,
    /// The servo.
    pub motor: String,
    /// What it was asked to do.
    pub trajectory: String,
    /// Weight (kg).
    pub mass: f64,
    /// From the axis to the weight (m).
    pub arm: f64,
    /// Proportional gain in the servo's own unit.
    pub gain: f64,
    /// Supply (V).
    pub supply: f64,
    /// Times (s).
    pub time: Vec<f64>,
    /// Commands (rad).
    pub goal: Vec<f64>,
    /// Measured positions (rad).
    pub position: Vec<f64>,
    /// Measured velocities (rad/s).
    pub velocity: Vec<f64>,
    /// Measured voltages on the winding (V): duty times the supply's. None of a log that was interpolated (`dt`), since that was done
    /// across the wrap of unsigned numbers, or whose servo did not tell its duty.
    pub voltage: Option<Vec<f64>>,
    /// Whether the motor is on.
    pub enabled: Vec<bool>,
    /// What the time stamps are like.
    pub clock: Clock,
}

#[derive(serde::Deserialize)]
struct File {
    mass: f64,
    length: f64,
    kp: f64,
    vin: f64,
    motor: String,
    trajectory: String,
    #[serde(default)]
    dt: Option<f64>,
    entries: Vec<Entry>,
}

#[derive(serde::Deserialize)]
struct Entry {
    timestamp: f64,
    goal_position: f64,
    position: f64,
    speed: f64,
    load: f64,
    input_volts: f64,
    torque_enable: bool,
}

impl BenchLog {
    /// Reads a log.
    ///
    /// # Errors
    /// [`AugmentationError::Io`]; [`AugmentationError::Log`] with line or entry for what is no such log: missing keys, numbers that
    /// are not finite, times that do not rise, gaps, positions that cannot be radians.
    pub fn read(path: &Path) -> Result<Self, AugmentationError> {
        let text = std::fs::read_to_string(path).map_err(AugmentationError::io(path))?;
        let file: File = serde_json::from_str(&text).map_err(|error| {
            let place = format!("line {}, column {}", error.line(), error.column());
            AugmentationError::log(path, place, "a log of a BAM bench", error)
        })?;
        let positive = [("mass", file.mass), ("length", file.length), ("kp", file.kp), ("vin", file.vin)];
        if let Some((key, value)) = positive.into_iter().find(|(_, value)| !(value.is_finite() && *value > 0.0)) {
            return Err(AugmentationError::log(path, key, "a number above 0", value));
        }
        for (i, entry) in file.entries.iter().enumerate() {
            let place = |key: &str| format!("entry {i}, {key}");
            for (key, value) in [
                ("timestamp", entry.timestamp),
                ("goal_position", entry.goal_position),
                ("position", entry.position),
                ("speed", entry.speed),
                ("load", entry.load),
                ("input_volts", entry.input_volts),
            ] {
                if !value.is_finite() {
                    return Err(AugmentationError::log(path, place(key), "a finite number", value));
                }
            }
            for (key, value) in [("goal_position", entry.goal_position), ("position", entry.position)] {
                if value.abs() > FARTHEST {
                    let expected = format!("radians, at most two turns ({FARTHEST:.1})");
                    let got = format!("{value} (degrees, or raw ticks?)");
                    return Err(AugmentationError::log(path, place(key), expected, got));
                }
            }
        }
        let column = |of: fn(&Entry) -> f64| file.entries.iter().map(of).collect::<Vec<f64>>();
        let time = column(|entry| entry.timestamp);
        let clock = Clock::of(&time).map_err(|(i, expected, got)| {
            AugmentationError::log(path, format!("entry {i}, timestamp"), expected, got)
        })?;
        let signed = |load: f64| if load > 32767.0 { load - 65536.0 } else { load };
        let voltage = || file.entries.iter().map(|e| signed(e.load) / DYNAMIXEL_DUTY_UNITS * e.input_volts).collect();
        let told = file.dt.is_none() && file.entries.iter().any(|entry| entry.load != 0.0);
        Ok(Self {
            name: path.file_stem().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default(),
            trajectory: file.trajectory.clone(),
            motor: file.motor.clone(),
            mass: file.mass,
            arm: file.length,
            gain: file.kp,
            supply: file.vin,
            goal: column(|entry| entry.goal_position),
            position: column(|entry| entry.position),
            velocity: column(|entry| entry.speed),
            voltage: told.then(voltage),
            enabled: file.entries.iter().map(|entry| entry.torque_enable).collect(),
            time,
            clock,
        })
    }

    /// Returns the log at equal steps of `1 / rate` seconds from its first time stamp on, numbers between two stamps by a straight
    /// line; the motor is on where it was at the stamp before.
    pub fn at(&self, rate: f64) -> BenchRun {
        let (first, last) = (self.time[0], self.time[self.time.len() - 1]);
        let rows = ((last - first) * rate).floor() as usize + 1;
        let (mut next, mut places) = (1, Vec::with_capacity(rows));
        for row in 0..rows {
            let t = first + row as f64 / rate;
            while next + 1 < self.time.len() && self.time[next] < t {
                next += 1;
            }
            let share = (t - self.time[next - 1]) / (self.time[next] - self.time[next - 1]);
            places.push((next, share.clamp(0.0, 1.0)));
        }
        let between = |values: &[f64]| -> Vec<f64> {
            places.iter().map(|(i, share)| values[i - 1] + share * (values[*i] - values[i - 1])).collect()
        };
        BenchRun {
            rate,
            goal: between(&self.goal),
            position: between(&self.position),
            velocity: between(&self.velocity),
            voltage: self.voltage.as_ref().map(|voltage| between(voltage)),
            enabled: places.iter().map(|(i, share)| self.enabled[if *share < 1.0 { i - 1 } else { *i }]).collect(),
        }
    }
}

/// A log at equal time steps.
#[derive(Debug, Clone, PartialEq)]
pub struct BenchRun {
    /// Rows per second (Hz).
    pub rate: f64,
    /// Commands (rad).
    pub goal: Vec<f64>,
    /// Measured positions (rad).
    pub position: Vec<f64>,
    /// Measured velocities (rad/s).
    pub velocity: Vec<f64>,
    /// Measured voltages (V).
    pub voltage: Option<Vec<f64>>,
    /// Whether the motor is on.
    pub enabled: Vec<bool>,
}

impl BenchRun {
    /// Returns the commands.
    pub fn commands(&self) -> BenchCommands<'_> {
        BenchCommands { step: 1.0 / self.rate, goal: &self.goal, enabled: &self.enabled }
    }

    /// Simulates a bench along the commands, from where the log begins, and returns both as a trace.
    pub fn simulated(&self, log: &BenchLog, bench: &PendulumBench) -> Trace {
        let motion = bench.run(self.commands(), self.position[0], self.velocity[0]);
        let enabled: Vec<f64> = self.enabled.iter().map(|on| f64::from(u8::from(*on))).collect();
        let mut measured: Vec<(&str, &[f64])> = vec![("position", &self.position), ("velocity", &self.velocity)];
        if let Some(voltage) = &self.voltage {
            measured.push(("voltage", voltage));
        }
        let mut block = BlockTrace {
            name: "servo".into(),
            class: log.motor.clone(),
            simulated: Columns::new(&[
                ("position", &motion.position),
                ("velocity", &motion.velocity),
                ("current", &motion.current),
                ("voltage", &motion.voltage),
            ]),
            force: Columns::new(&[("load", &motion.load)]),
            reference: Columns::new(&[("position", &self.goal), ("enabled", &enabled)]),
            measured: Columns::new(&measured),
            ..BlockTrace::default()
        };
        block.selection = block.by_name();
        let source = format!("bench: {} kg on {} m, kp {}, {} V", log.mass, log.arm, log.gain, log.supply);
        Trace { name: log.name.clone(), source, rate: self.rate, blocks: vec![block] }
    }
}
