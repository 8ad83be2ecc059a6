//! Cycles of a chain of servos: commands out, positions in.

use std::time::{Duration, Instant};

use lifelike_runtime::udp::packet::Received;
use lifelike_runtime::{Measurement, Mode, Wire};

use crate::imu::Imu;
use crate::line::{ALERT, Line, SLACK};
use crate::model::{Model, VELOCITY_UNIT, address, hardware_errors};
use crate::packet::{sync_read, sync_write};
use crate::servos::Servo;

/// Bytes from the present current on: up to the position, and up to the temperature.
const SHORT: usize = 10;
const LONG: usize = 21;
/// Cycles of which one reads voltage and temperature, too.
const HEALTH: u64 = 32;
/// Watchdog of driven servos: five times 20 ms without a request, after which they stop.
const WATCHDOG: u8 = 5;
/// Bytes of an answer beside its content.
const STATUS: usize = 11;

/// State of one servo in one cycle.
#[derive(Debug, Clone, Copy)]
struct Present {
    has_alert: bool,
    current: i16,
    velocity: i32,
    position: i32,
    /// Voltage (V) and temperature (degrees Celsius), where they were read.
    health: Option<(f32, f32)>,
}

impl Present {
    /// Reads an answer with its error; none for one of another length or one that refuses.
    fn read(answer: &[u8], length: usize) -> Option<Self> {
        let (error, bytes) =
            answer.split_first().filter(|(error, bytes)| **error & !ALERT == 0 && bytes.len() == length)?;
        let word = |i: usize| u16::from_le_bytes([bytes[i], bytes[i + 1]]);
        let long = |i: usize| i32::from_le_bytes([bytes[i], bytes[i + 1], bytes[i + 2], bytes[i + 3]]);
        let health = (length == LONG).then(|| (0.1 * f32::from(word(18)), f32::from(bytes[20])));
        let (current, velocity, position) = (word(0) as i16, long(2), long(6));
        Some(Self { has_alert: error & ALERT != 0, current, velocity, position, health })
    }
}

/// All servos of a robot, in the order of its joints.
pub(crate) struct Chain {
    line: Line,
    servos: Vec<Servo>,
    ids: Vec<u8>,
    /// Torque of one unit of current (N m); none where it is not measured.
    torque_unit: Vec<Option<f64>>,
    /// Least and greatest positions that each servo accepts.
    limits: Vec<(i32, i32)>,
    /// Hardware errors that were reported.
    reported: Vec<bool>,
    /// Answers of the last cycle, and newest voltages (V) and temperatures (degrees Celsius).
    answers: Vec<Option<Present>>,
    health: Vec<(f32, f32)>,
    imu: Option<Imu>,
    /// Orientation of a root that is fixed to the world (`wxyz`).
    fixed: Option<[f32; 4]>,
    /// D, I and P gain that each servo has now.
    gains: Vec<[u8; 6]>,
    is_driven: bool,
    begin: Instant,
    /// Time between two cycles, and that of the next.
    period: Duration,
    next: Instant,
    cycles: u64,
    sequence: u32,
}

impl Chain {
    /// Servos that were checked, with the positions that they accept.
    pub(crate) fn new(
        line: Line,
        servos: Vec<Servo>,
        limits: Vec<(i32, i32)>,
        imu: Option<Imu>,
        fixed: Option<[f32; 4]>,
        command_hz: f64,
    ) -> Self {
        let unit = |servo: &Servo| Some(Model::by_name(&servo.model)?.current_unit? * servo.torque_constant?);
        let now = Instant::now();
        Self {
            ids: servos.iter().map(|servo| servo.id).collect(),
            torque_unit: servos.iter().map(unit).collect(),
            reported: vec![false; servos.len()],
            answers: vec![None; servos.len()],
            health: vec![(f32::NAN, f32::NAN); servos.len()],
            gains: servos.iter().map(|servo| gains(servo, 1.0, 1.0)).collect(),
            is_driven: false,
            begin: now,
            period: Duration::from_secs_f64(1.0 / command_hz),
            next: now,
            cycles: 0,
            sequence: 0,
            line,
            servos,
            limits,
            imu,
            fixed,
        }
    }

    /// Reads all servos once; returns whether each of them answered.
    pub(crate) fn cycle(&mut self) -> std::io::Result<bool> {
        let Self { line, ids, answers, health, .. } = self;
        let length = if self.cycles.is_multiple_of(HEALTH) { LONG } else { SHORT };
        self.cycles += 1;
        answers.fill(None);
        sync_read(address::PRESENT, length as u16, ids, &mut line.out);
        line.send()?;
        let mut missing = ids.len();
        line.collect(ids.len() * (STATUS + length), SLACK, |packet| {
            let place = ids.iter().position(|id| *id == packet.id);
            if let (Some(j), Some(present)) = (place, Present::read(&packet.parameters, length)) {
                missing -= usize::from(answers[j].replace(present).is_none());
                health[j] = present.health.unwrap_or(health[j]);
            }
            missing == 0
        })?;
        Ok(missing == 0)
    }

    /// Writes the answers as a measurement. A servo that was silent or has a hardware error counts as not finite: the gate brakes,
    /// and names its joint. Returns false where nobody answered, and where the IMU's reading is too old.
    fn measure(&mut self, into: &mut Measurement) -> bool {
        let imu = match &self.imu {
            Some(imu) => match imu.fresh() {
                Some(packet) => Some(packet),
                None => return false,
            },
            None => None,
        };
        if self.answers.iter().all(Option::is_none) {
            return false;
        }
        for (j, servo) in self.servos.iter().enumerate() {
            let answer = self.answers[j].filter(|present| !present.has_alert);
            let sign = f64::from(servo.sign);
            into.position[j] = answer.map_or(f32::NAN, |present| servo.angle(present.position) as f32);
            into.velocity[j] =
                answer.map_or(f32::NAN, |present| (sign * f64::from(present.velocity) * VELOCITY_UNIT) as f32);
            let torque = answer.zip(self.torque_unit[j]);
            into.torque[j] =
                torque.map_or(f32::NAN, |(present, unit)| (sign * f64::from(present.current) * unit) as f32);
            into.temperature[j] = self.health[j].1;
        }
        into.battery = self.health.iter().map(|(voltage, _)| *voltage).fold(f32::NAN, f32::min);
        if let Some(packet) = imu {
            into.orientation = packet.orientation;
            into.gyroscope_b = packet.gyroscope_b;
            into.accelerometer_b = packet.accelerometer_b;
            (into.stop, into.external) = (packet.stop, packet.external);
        } else if let Some(orientation) = self.fixed {
            into.orientation = orientation;
        }
        self.sequence = self.sequence.wrapping_add(1);
        into.sequence = self.sequence;
        into.clock = self.begin.elapsed().as_nanos() as u64;
        true
    }

    /// Logs each hardware error once.
    fn report(&mut self) -> std::io::Result<()> {
        for j in 0..self.servos.len() {
            if self.answers[j].is_some_and(|present| present.has_alert) && !self.reported[j] {
                self.reported[j] = true;
                let status = self.line.read(self.ids[j], address::HARDWARE_ERROR, 1)?;
                let errors = status.map_or("an unknown one".into(), |status| hardware_errors(status[0]));
                tracing::error!("{}: hardware error: {errors}", self.servos[j].words());
            }
        }
        Ok(())
    }
}

impl Wire for Chain {
    fn receive(&mut self, into: &mut Measurement) -> std::io::Result<bool> {
        let now = Instant::now();
        if now < self.next {
            return Ok(false);
        }
        // A cycle that was late does not hurry those after it.
        self.next = (self.next + self.period).max(now);
        if let Some(imu) = &mut self.imu {
            imu.receive()?;
        }
        self.cycle()?;
        self.report()?;
        Ok(self.measure(into))
    }

    fn send(&mut self, safe: &Received) -> std::io::Result<()> {
        let drives = safe.mode == Mode::Position;
        if !drives && !self.is_driven {
            return Ok(());
        }
        let Self { line, servos, ids, limits, .. } = self;
        let set_all = |line: &mut Line, to: u16, value: u8| {
            sync_write(to, ids.iter().map(|id| (*id, [value])), &mut line.out);
            line.send()
        };
        if safe.mode == Mode::Off {
            self.is_driven = false;
            set_all(line, address::TORQUE_ENABLE, 0)?;
            return set_all(line, address::BUS_WATCHDOG, 0);
        }
        let share = |now: f32, own: f64| if own > 0.0 { f64::from(now) / own } else { 1.0 };
        let gain = |j: usize| gains(&servos[j], share(safe.kp[j], servos[j].kp), share(safe.kd[j], servos[j].kd));
        if (0..servos.len()).any(|j| gain(j) != self.gains[j]) {
            (0..servos.len()).for_each(|j| self.gains[j] = gain(j));
            let values = ids.iter().copied().zip(self.gains.iter().copied());
            sync_write(address::POSITION_GAINS, values, &mut line.out);
            line.send()?;
        }
        // The firmware damps changes of the error: a goal that follows the joint would not brake it.
        if !drives {
            return Ok(());
        }
        let goals = servos.iter().zip(limits.iter()).zip(&safe.position).map(|((servo, (least, most)), target)| {
            (servo.id, servo.units(f64::from(*target)).clamp(*least, *most).to_le_bytes())
        });
        sync_write(address::GOAL_POSITION, goals, &mut line.out);
        line.send()?;
        if !std::mem::replace(&mut self.is_driven, true) {
            set_all(line, address::BUS_WATCHDOG, WATCHDOG)?;
            set_all(line, address::TORQUE_ENABLE, 1)?;
        }
        Ok(())
    }
}

/// Returns D, I and P gain of a servo as bytes, scaled by shares of stiffness and damping.
fn gains(servo: &Servo, stiffness: f64, damping: f64) -> [u8; 6] {
    let scaled = |gain: u16, share: f64| ((f64::from(gain) * share).round().clamp(0.0, 16_383.0) as u16).to_le_bytes();
    let ([d, e], [p, q]) = (scaled(servo.d_gain, damping), scaled(servo.p_gain, stiffness));
    [d, e, 0, 0, p, q]
}
