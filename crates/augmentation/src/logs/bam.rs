//! Logs of test benches: a servo that turns a weight on an arm.
//!
//! BAM's (github.com/Rhoban/bam) are JSON: an object with `mass` (kg), `arm_mass` (kg, 0 where not said), `length`
//! (m), `kp` (the servo's own unit), `vin` (V), `motor`, `trajectory`, and `entries`: `timestamp` (s), `goal_position`
//! and `position` (rad), `speed` (rad/s), `load`, `input_volts` (V), `torque_enable`. The load is the duty in 885ths,
//! or the duty itself if no number exceeds 1; `load_unit` may say `885ths`, `%` or `1`. Negative numbers may be unsigned
//! 16 bits. It is 0 throughout for a servo that does not tell it. Those of other servos are tables ([`super::bench_table`]).

use std::f64::consts::TAU;
use std::path::Path;

use lifelike_sim::bench::{BenchCommands, PendulumBench};
use lifelike_sim::trace::{BlockTrace, Columns, Trace};

use super::clock::Clock;
use super::load::{self, LoadUnit};
use super::{bench_checks, bench_table};
use crate::{AugmentationError, FromInput};

/// Units of a Dynamixel's duty of 1.
pub(crate) const DYNAMIXEL_DUTY_UNITS: f64 = 885.0;
/// A Dynamixel's duty for an error of one radian and a gain of 1: 4096 steps a turn, gains in 256ths, a duty of 1 in
/// 885ths. Present PWM against Goal Position of an XL330's logs has this slope to 1%; its manual would give twice as
/// much.
pub const DYNAMIXEL_DUTY: f64 = 4096.0 / TAU / (256.0 * DYNAMIXEL_DUTY_UNITS);
/// A Feetech's: measured on an STS3215 with an oscilloscope by BAM's authors (github.com/Rhoban/bam).
pub const FEETECH_DUTY: f64 = 0.166;

/// Returns the duty that a servo of this name commands for an error of one radian and a gain of 1 (1/rad), by its data
/// sheet.
pub fn commanded_duty(motor: &str) -> Option<f64> {
    match motor {
        "xl330" => Some(DYNAMIXEL_DUTY),
        "sts3250" => Some(FEETECH_DUTY),
        _ => None,
    }
}

/// Log of a bench, at the times it was written.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BenchLog {
    /// Name of the file.
    pub name: String,
    /// The servo.
    pub motor: String,
    /// Name of the commanded trajectory.
    pub trajectory: String,
    /// Weight (kg).
    pub mass: f64,
    /// Mass of the arm, a rod from the axis to the weight (kg).
    pub arm_mass: f64,
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
    /// Measured voltages on the winding (V): duty times the supply's. None of a log that was interpolated (`dt`),
    /// since that was done across the wrap of unsigned numbers. None of a servo that did not tell its duty.
    pub voltage: Option<Vec<f64>>,
    /// True while the motor is on.
    pub enabled: Vec<bool>,
    /// Regularity of the time stamps.
    pub clock: Clock,
    /// Remarks on what was guessed and cannot be told from the numbers.
    pub notes: Vec<String>,
}

#[derive(serde::Deserialize)]
struct File {
    mass: f64,
    #[serde(default)]
    arm_mass: f64,
    length: f64,
    kp: f64,
    vin: f64,
    #[serde(default)]
    load_unit: Option<LoadUnit>,
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

impl File {
    fn log(self) -> BenchLog {
        let column = |of: fn(&Entry) -> f64| self.entries.iter().map(of).collect::<Vec<f64>>();
        BenchLog {
            mass: self.mass,
            arm_mass: self.arm_mass,
            arm: self.length,
            gain: self.kp,
            supply: self.vin,
            time: column(|entry| entry.timestamp),
            goal: column(|entry| entry.goal_position),
            position: column(|entry| entry.position),
            velocity: column(|entry| entry.speed),
            voltage: self.voltage(),
            enabled: self.entries.iter().map(|entry| entry.torque_enable).collect(),
            motor: self.motor,
            trajectory: self.trajectory,
            ..BenchLog::default()
        }
    }

    fn voltage(&self) -> Option<Vec<f64>> {
        let largest = self.largest_load();
        let told = self.dt.is_none() && (largest > 0.0 || self.entries.iter().any(|entry| entry.load.is_nan()));
        // No motor moves by a few 885ths of its supply, so small numbers are the duty itself.
        let guess = if largest <= 1.0 { LoadUnit::Duty } else { LoadUnit::Dynamixel };
        let unit = self.load_unit.unwrap_or(guess).whole();
        told.then(|| self.entries.iter().map(|entry| signed(entry.load) / unit * entry.input_volts).collect())
    }

    fn largest_load(&self) -> f64 {
        self.entries.iter().map(|entry| signed(entry.load).abs()).fold(0.0, f64::max)
    }

    /// Returns the largest load, where its unit had to be guessed among those of whole numbers.
    fn guessed(&self) -> Option<f64> {
        Some(self.largest_load()).filter(|largest| self.load_unit.is_none() && *largest > 1.0)
    }
}

/// Returns a load as a signed number.
fn signed(load: f64) -> f64 {
    if load > 32767.0 { load - 65536.0 } else { load }
}

impl BenchLog {
    /// Reads a log: BAM's JSON, or a table (`.csv`).
    ///
    /// # Errors
    /// [`AugmentationError::Input`]; [`AugmentationError::Log`] with line or entry for what is no such log: missing keys, numbers that
    /// are not finite, times that do not rise, gaps, and numbers of another unit or sign.
    pub fn read(path: &Path) -> Result<Self, AugmentationError> {
        let text = std::fs::read_to_string(path).map_err(AugmentationError::io(path))?;
        let text = text.trim_start_matches('\u{feff}');
        let mut guessed = None;
        let mut log = if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv")) {
            bench_table::read(text, path)?
        } else {
            let file: File = serde_json::from_str(text).map_err(|error| {
                let place = format!("line {}, column {}", error.line(), error.column());
                AugmentationError::log(path, place, "a log of a BAM bench", error)
            })?;
            guessed = file.guessed();
            file.log()
        };
        let fail = |(place, expected, got): bench_checks::Fault| AugmentationError::log(path, place, expected, got);
        bench_checks::numbers(&log).map_err(fail)?;
        log.clock = Clock::of(&log.time)
            .map_err(|(i, expected, got)| fail((format!("entry {i}, timestamp"), expected, got)))?;
        bench_checks::units(&log).map_err(fail)?;
        log.notes.extend(load::check(&log, guessed).map_err(fail)?);
        log.name = path.file_stem().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        Ok(log)
    }

    /// Returns the log at equal steps of `1 / rate` seconds from its first time stamp on, numbers between two stamps
    /// by a straight line. The motor is on where it was at the stamp before.
    pub fn at(&self, rate: f64) -> BenchRun {
        let (first, last) = (self.time[0], self.time[self.time.len() - 1]);
        // Time stamps are rounded.
        let rows = ((last - first) * rate + 1e-3).floor() as usize + 1;
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
    /// True while the motor is on.
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
        let arm = if log.arm_mass > 0.0 { format!(" of {} kg", log.arm_mass) } else { String::new() };
        let source = format!("bench: {} kg on {} m{arm}, kp {}, {} V", log.mass, log.arm, log.gain, log.supply);
        Trace { name: log.name.clone(), source, rate: self.rate, blocks: vec![block] }
    }
}
