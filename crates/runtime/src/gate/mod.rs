//! The safety gate: the only maker of commands.
//!
//! [`Gate::receive`] judges packets, [`Gate::pass`] turns an intent into a [`SafeCommand`]. Targets are limited in position,
//! speed and acceleration. Gains are scaled down where the torque would be above what the motor's heat allows. A trip
//! stays: from then on the gate only brakes. A fall alone can be pardoned, for getting up.

mod command;
mod encoders;
mod limiter;
mod limits;
mod thermal;
mod trip;

use encoders::Encoder;
use limiter::Limiter;
use thermal::Heat;

pub use command::{Mode, SafeCommand};
pub use limits::{JointLimits, LimitSettings, Limits};
pub use trip::{Cause, Trip};

use crate::bus::Measurement;
use crate::packets::{Arrival, Counts, Monitor};

/// Fresh packets that must arrive before anything is believed.
const FIRST_PACKETS: u64 = 5;
/// Time that the battery must be low (s).
const BATTERY_TIME: f32 = 1.0;
/// Time that a joint must be too fast (s).
const VELOCITY_TIME: f32 = 0.02;

/// Wish of the state machine for one tick.
#[derive(Debug, Clone, Copy)]
pub struct Intent<'a> {
    /// Control mode.
    pub mode: Mode,
    /// Joint targets, `[J]` (rad); read in [`Mode::Position`] only.
    pub targets: &'a [f32],
    /// Largest speed of targets (rad/s).
    pub rate: f32,
    /// Joint positions of the reference, `[J]` (rad); empty: not compared.
    pub reference: &'a [f32],
    /// Up direction of the reference, seen from its root; none: not compared.
    pub up_b: Option<[f32; 3]>,
}

/// The gate of one run.
#[derive(Debug)]
pub struct Gate {
    limits: Limits,
    /// Nominal time between commands (s).
    dt: f32,
    command: SafeCommand,
    targets: Vec<Limiter>,
    heat: Vec<Heat>,
    encoders: Vec<Encoder>,
    /// Time for which each joint has been off the reference, and too fast (s).
    off: Vec<f32>,
    fast: Vec<f32>,
    low_battery: f32,
    monitor: Monitor,
    measured: Measurement,
    /// Clock of the last packet that is newer than all before (ns).
    clock: u64,
    last_tick: Option<u64>,
    /// Defect of the first of the last packets that were not used.
    defect: Option<Trip>,
    trip: Option<Trip>,
    is_driving: bool,
    has_measured: bool,
}

impl Gate {
    /// A gate for commands at a rate (Hz).
    pub fn new(limits: Limits, command_hz: f64) -> Self {
        let joints = limits.joints.len();
        let zeros = || vec![0.0; joints];
        Self {
            dt: (1.0 / command_hz) as f32,
            command: SafeCommand { sequence: 0, mode: Mode::Off, position: zeros(), kp: zeros(), kd: zeros() },
            targets: vec![Limiter::default(); joints],
            heat: vec![Heat::default(); joints],
            encoders: vec![Encoder::default(); joints],
            off: zeros(),
            fast: zeros(),
            low_battery: 0.0,
            monitor: Monitor::default(),
            measured: Measurement::new(joints),
            clock: 0,
            last_tick: None,
            defect: None,
            trip: None,
            is_driving: false,
            has_measured: false,
            limits,
        }
    }

    /// Returns the limits.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Returns the trip, where there was one.
    pub fn trip(&self) -> Option<Trip> {
        self.trip
    }

    /// Returns whether the gate brakes for a fall: by the cause itself, or by a joint that was flung on the way down.
    ///
    /// A robot whose root is tilted beyond `tilt_max` against `up_b` lies. Its arms hit the floor faster than motors turn.
    pub(crate) fn has_fallen(&self, up_b: [f32; 3]) -> bool {
        let lies = tilt(self.measured.orientation, up_b) > self.limits.settings.tilt_max as f32;
        self.trip.is_some_and(|trip| trip.cause.is_fall() || (trip.cause == Cause::Velocity && lies))
    }

    /// Lets a robot that fell be driven again; any other trip stays.
    pub(crate) fn pardon_fall(&mut self, up_b: [f32; 3]) {
        if self.has_fallen(up_b) {
            self.trip = None;
        }
    }

    /// Returns counts of packets.
    pub fn counts(&self) -> Counts {
        self.monitor.counts
    }

    /// Returns the newest usable measurement; none before enough have arrived.
    pub fn measured(&self) -> Option<&Measurement> {
        (self.has_measured && self.monitor.counts.used >= FIRST_PACKETS).then_some(&self.measured)
    }

    /// Returns the modelled heat of each motor; 1 is its continuous rating.
    pub fn heat(&self) -> impl Iterator<Item = f32> + '_ {
        self.heat.iter().map(|heat| heat.0)
    }

    /// Returns the last command.
    pub fn command(&self) -> &SafeCommand {
        &self.command
    }

    /// Looks at a packet that arrived at `now` (ns); returns whether it is used.
    pub fn receive(&mut self, now: u64, packet: &Measurement) -> bool {
        if let Some((what, joint)) = packet.non_finite() {
            self.monitor.counts.non_finite += 1;
            let joint = (what == "position" || what == "velocity").then_some(joint as u16);
            self.defect.get_or_insert(Trip { time: now, cause: Cause::NonFinite, joint, value: None, limit: 0.0 });
            return false;
        }
        let Arrival::New { .. } = self.monitor.arrival(now, packet.sequence, packet.clock) else { return false };
        // Since the last packet, used or not: a jump does not become possible by being refused for a while.
        let elapsed = packet.clock.saturating_sub(self.clock) as f64 * 1e-9;
        let dt = if self.has_measured { elapsed.clamp(0.0, self.limits.settings.overrun_time) as f32 } else { 0.0 };
        self.clock = packet.clock;
        if self.has_measured && self.is_driving {
            for (joint, (encoder, limits)) in self.encoders.iter().zip(&self.limits.joints).enumerate() {
                let (value, limit) = encoder.jump(packet.position[joint], limits, dt);
                if value > limit {
                    self.defect.get_or_insert(trip(now, Cause::EncoderJump, Some(joint), value, limit));
                    return false;
                }
            }
        }
        self.defect = None;
        self.has_measured = true;
        self.measured.copy_from(packet);
        self.check_packet(now, dt);
        true
    }

    /// Checks the new measurement.
    fn check_packet(&mut self, now: u64, dt: f32) {
        let settings = &self.limits.settings;
        let (freeze, lowest) = (settings.freeze_time as f32, settings.battery_min as f32);
        let hottest = settings.temperature_max as f32;
        let delay = self.monitor.delay() as f32;
        let delay_max = settings.delay_max as f32;
        let mut found = None;
        if self.measured.stop {
            found = Some(trip(now, Cause::Button, None, 1.0, 0.0));
        } else if delay > delay_max {
            found = Some(trip(now, Cause::Delayed, None, delay, delay_max));
        } else if delay < -delay_max {
            found = Some(trip(now, Cause::ClockJump, None, -delay, delay_max));
        }
        self.low_battery = if self.measured.battery < lowest { self.low_battery + dt } else { 0.0 };
        if self.low_battery > BATTERY_TIME {
            found = found.or(Some(trip(now, Cause::Battery, None, self.measured.battery, lowest)));
        }
        for (j, limits) in self.limits.joints.iter().enumerate() {
            let (position, velocity) = (self.measured.position[j], self.measured.velocity[j]);
            let frozen = self.encoders[j].take(position, velocity, self.targets[j].position, limits, dt);
            if frozen > freeze {
                found = found.or(Some(trip(now, Cause::FrozenEncoder, Some(j), frozen, freeze)));
            }
            self.fast[j] = if velocity.abs() > limits.velocity { self.fast[j] + dt } else { 0.0 };
            if self.fast[j] > VELOCITY_TIME {
                found = found.or(Some(trip(now, Cause::Velocity, Some(j), velocity, limits.velocity)));
            }
            if self.measured.temperature[j] > hottest {
                let temperature = self.measured.temperature[j];
                found = found.or(Some(trip(now, Cause::Temperature, Some(j), temperature, hottest)));
            }
        }
        self.latch(found);
    }

    /// Turns an intent into the command of this tick at `now` (ns).
    pub fn pass(&mut self, now: u64, intent: Intent<'_>) -> &SafeCommand {
        let elapsed = self.last_tick.map_or(0.0, |last| now.saturating_sub(last) as f64 * 1e-9) as f32;
        self.last_tick = Some(now);
        self.warm(elapsed);
        if self.is_driving {
            self.check_tick(now, elapsed, &intent);
        }
        let known = self.measured().is_some();
        let mode = match intent.mode {
            Mode::Off => Mode::Off,
            _ if self.trip.is_some() => Mode::Damp,
            Mode::Position if known => Mode::Position,
            _ => Mode::Damp,
        };
        if mode == Mode::Position && !self.is_driving {
            self.begin();
        }
        self.is_driving = mode == Mode::Position;
        self.write(mode, &intent);
        &self.command
    }

    /// Begins to drive from where the joints are.
    fn begin(&mut self) {
        for (j, limits) in self.limits.joints.iter().enumerate() {
            let position = self.measured.position[j];
            self.targets[j].begin(position, limits);
            self.encoders[j].begin(position, self.targets[j].position);
        }
        self.off.fill(0.0);
        self.fast.fill(0.0);
    }

    /// Writes the command.
    fn write(&mut self, mode: Mode, intent: &Intent<'_>) {
        let (derate, hottest) =
            (self.limits.settings.temperature_derate as f32, self.limits.settings.temperature_max as f32);
        self.command.sequence = self.command.sequence.wrapping_add(1);
        self.command.mode = mode;
        for (j, limits) in self.limits.joints.iter().enumerate() {
            let (position, velocity) = (self.measured.position[j], self.measured.velocity[j]);
            let target = match mode {
                Mode::Position => {
                    let goal = intent.targets.get(j).copied().filter(|goal| goal.is_finite());
                    let goal = goal.unwrap_or(self.targets[j].position);
                    self.targets[j].step(goal, intent.rate.max(0.0), limits, self.dt)
                }
                _ => position.clamp(limits.position.0, limits.position.1),
            };
            let (kp, kd) = match mode {
                Mode::Off => (0.0, 0.0),
                Mode::Damp => (0.0, limits.kd),
                Mode::Position => (limits.kp, limits.kd),
            };
            let allowed = self.heat[j].allowed(limits, self.measured.temperature[j], derate, hottest);
            let torque = (kp * (target - position) - kd * velocity).abs();
            // The two gains are scaled together, so that the joint stays as damped as it was.
            let share = if torque > allowed { allowed / torque * (1.0 - f32::EPSILON * 4.0) } else { 1.0 };
            self.command.position[j] = target;
            self.command.kp[j] = kp * share;
            self.command.kd[j] = kd * share;
        }
    }

    /// Goes on with the modelled heat, by the measured torque or else the one that was asked for.
    fn warm(&mut self, elapsed: f32) {
        let share = elapsed / self.limits.settings.thermal_time as f32;
        for (j, limits) in self.limits.joints.iter().enumerate() {
            let measured = self.measured.torque[j];
            let asked = self.command.torque(j, self.measured.position[j], self.measured.velocity[j]);
            let torque = if measured.is_finite() { measured } else { asked };
            self.heat[j].add(torque, limits.torque_continuous, share);
        }
    }

    /// Checks what changes without a packet.
    fn check_tick(&mut self, now: u64, elapsed: f32, intent: &Intent<'_>) {
        let settings = &self.limits.settings;
        let (overrun, lost) = (settings.overrun_time as f32, settings.lost_time as f32);
        let (furthest, patience) = (settings.tracking_max as f32, settings.tracking_time as f32);
        let silence = self.monitor.silence(now) as f32;
        let mut found = None;
        if elapsed > overrun {
            found = Some(trip(now, Cause::Overrun, None, elapsed, overrun));
        } else if silence > lost || self.stale(now) > lost {
            found = Some(self.defect.unwrap_or(trip(now, Cause::Lost, None, silence, lost)));
        }
        if silence > 0.5 * lost {
            self.monitor.counts.late_ticks += 1;
        }
        let most = settings.tilt_max as f32;
        // A run that ends compares with nothing any more.
        if let Some(up_b) = intent.up_b.filter(|_| intent.mode == Mode::Position) {
            let tilt = tilt(self.measured.orientation, up_b);
            if tilt.is_nan() || tilt > most {
                found = found.or(Some(trip(now, Cause::Tilt, None, tilt, most)));
            }
        }
        if intent.mode == Mode::Position
            && let Some(joint) = intent.targets.iter().position(|target| !target.is_finite())
        {
            found = found.or(Some(trip(now, Cause::Target, Some(joint), f32::NAN, 0.0)));
        }
        for (j, limits) in self.limits.joints.iter().enumerate() {
            if let Some(reference) = intent.reference.get(j) {
                let distance =
                    (reference.clamp(limits.position.0, limits.position.1) - self.measured.position[j]).abs();
                self.off[j] = if distance > furthest { self.off[j] + elapsed } else { 0.0 };
                if self.off[j] > patience {
                    found = found.or(Some(trip(now, Cause::Tracking, Some(j), distance, furthest)));
                }
            }
            if self.heat[j].0 > thermal::TRIP {
                found = found.or(Some(trip(now, Cause::Heat, Some(j), self.heat[j].0, thermal::TRIP)));
            }
        }
        self.latch(found);
    }

    /// Returns the time since the first packet in a row that could not be used (s).
    fn stale(&self, now: u64) -> f32 {
        self.defect.map_or(0.0, |defect| now.saturating_sub(defect.time) as f32 * 1e-9)
    }

    fn latch(&mut self, found: Option<Trip>) {
        if self.is_driving && self.trip.is_none() {
            self.trip = found;
        }
    }
}

fn trip(time: u64, cause: Cause, joint: Option<usize>, value: f32, limit: f32) -> Trip {
    let value = value.is_finite().then_some(value);
    Trip { time, cause, joint: joint.map(|joint| joint as u16), value, limit }
}

/// Returns the angle between the measured up direction, seen from the root, and the reference's (rad).
pub(crate) fn tilt([w, x, y, z]: [f32; 4], up_b: [f32; 3]) -> f32 {
    // Third row of the rotation matrix.
    let up = [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)];
    let cosine: f32 = up.iter().zip(&up_b).map(|(a, b)| a * b).sum();
    let square = |v: &[f32; 3]| v.iter().map(|x| x * x).sum::<f32>();
    (cosine / (square(&up) * square(&up_b)).sqrt()).clamp(-1.0, 1.0).acos()
}
