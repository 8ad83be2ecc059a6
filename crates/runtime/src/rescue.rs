//! Getting up after a fall.

use std::sync::Arc;

use lifelike_robot::{GetUp, GetUpScript, MeasuredState, Robot};

use crate::bus::Measurement;
use crate::error::RuntimeError;
use crate::gate::Gate;
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
    pub(crate) fn may_begin(&mut self, phase: Phase, gate: &Gate, up_b: [f32; 3]) -> bool {
        let fell = gate.has_fallen(up_b);
        if fell && !self.is_down && phase != Phase::Idle {
            (self.is_down, self.tries) = (true, 0);
            self.falls += 1;
        }
        self.is_down && (fell || gate.trip().is_none()) && self.tries < TRIES
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::gate::{Cause, Intent, Limits, Mode};

    const UP: [f32; 3] = [0.0, 0.0, 1.0];

    /// Sends `ticks` packets with a shoulder at this velocity (rad/s) and the root turned by this angle about x (rad).
    fn send(gate: &mut Gate, packet: &mut Measurement, ticks: u32, velocity: f32, angle: f32) {
        packet.orientation = [(0.5 * angle).cos(), (0.5 * angle).sin(), 0.0, 0.0];
        packet.velocity[1] = velocity;
        let targets = packet.position.clone();
        for _ in 0..ticks {
            packet.sequence += 1;
            packet.clock += 1_000_000;
            gate.receive(packet.clock, packet);
            let intent = Intent { mode: Mode::Position, targets: &targets, rate: 1.0, reference: &[], up_b: None };
            gate.pass(packet.clock, intent);
        }
    }

    #[test]
    fn an_arm_that_the_fall_flung_is_part_of_the_fall_and_one_of_a_standing_robot_is_not() {
        let robot = Arc::new(Robot::load("lima").unwrap());
        let mut gate = Gate::new(Limits::of(&robot, Default::default()).unwrap(), 1000.0);
        let mut packet = Measurement::new(robot.joints());
        send(&mut gate, &mut packet, 20, 0.0, 0.0);
        assert!(gate.trip().is_none() && !gate.has_fallen(UP));
        let fast = 1.1 * gate.limits().joints[1].velocity;
        send(&mut gate, &mut packet, 30, fast, 0.0);
        assert_eq!(gate.trip().map(|trip| trip.cause), Some(Cause::Velocity));
        gate.pardon_fall(UP);
        assert!(
            gate.trip().is_some() && !gate.has_fallen(UP),
            "a standing robot whose joint runs away is not pardoned"
        );
        send(&mut gate, &mut packet, 30, 0.0, 1.5);
        assert!(gate.has_fallen(UP));
        gate.pardon_fall(UP);
        assert!(gate.trip().is_none());
    }
}
