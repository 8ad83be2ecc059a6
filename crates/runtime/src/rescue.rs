//! Getting up after a fall.

use std::sync::Arc;

use lifelike_robot::{GetUp, GetUpScript, MeasuredState, Robot};

use crate::bus::Measurement;
use crate::error::RuntimeError;
use crate::gate::Trip;
use crate::phase::Phase;

/// Tries after one fall.
const TRIES: u32 = 3;
/// Greatest angular velocity of a robot that lies still (rad/s).
const STILL: f32 = 0.5;

/// The script that gets up, and what is known of the fall.
pub(crate) struct Rescue {
    script: GetUp,
    pub(crate) falls: u32,
    /// The robot fell and has not been on its feet since.
    is_down: bool,
    tries: u32,
    /// Ticks since the last step of the script.
    tick: usize,
}

impl Rescue {
    /// Makes it for a robot.
    ///
    /// # Errors
    /// The script is of another robot.
    pub(crate) fn new(script: &GetUpScript, robot: &Arc<Robot>) -> Result<Self, RuntimeError> {
        let script = GetUp::new(script, Arc::clone(robot))?;
        Ok(Self { script, falls: 0, is_down: false, tries: 0, tick: 0 })
    }

    /// Returns whether the robot has fallen, nothing is broken, and it may try once more.
    pub(crate) fn may_begin(&mut self, phase: Phase, trip: Option<Trip>) -> bool {
        let fell = trip.is_some_and(|trip| trip.cause.is_fall());
        if fell && !self.is_down && phase != Phase::Idle {
            (self.is_down, self.tries) = (true, 0);
            self.falls += 1;
        }
        self.is_down && (fell || trip.is_none()) && self.tries < TRIES
    }

    /// Begins a try from these joint positions (rad).
    pub(crate) fn begin(&mut self, position: &[f32]) {
        (self.tries, self.tick) = (self.tries + 1, 0);
        self.script.begin(position);
    }

    /// Forgets the fall: the robot is on its feet.
    pub(crate) fn end(&mut self) {
        self.is_down = false;
    }

    /// Returns whether the robot is on its feet.
    pub(crate) fn is_up(&mut self, measured: &Measurement) -> bool {
        self.script.is_on_its_feet(&state(measured))
    }

    /// Writes the targets of a tick (rad), of `ticks_per_step`.
    pub(crate) fn write(&mut self, measured: &Measurement, ticks_per_step: usize, targets: &mut [f32]) {
        if self.tick.is_multiple_of(ticks_per_step) {
            self.script.step(&state(measured), targets);
        }
        self.tick += 1;
    }
}

/// Returns whether a robot hardly turns.
pub(crate) fn is_still(measured: &Measurement) -> bool {
    measured.gyroscope_b.iter().map(|x| x * x).sum::<f32>().sqrt() < STILL
}

fn state(measured: &Measurement) -> MeasuredState<'_> {
    MeasuredState {
        joint_position: &measured.position,
        joint_velocity: &measured.velocity,
        root_orientation: measured.orientation,
        ..MeasuredState::default()
    }
}
