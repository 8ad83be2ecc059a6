//! Encoders that jump or freeze.

use super::limits::JointLimits;

/// Angle that an encoder may move beyond what its velocity allows (rad).
const SLACK: f32 = 0.1;
/// Angle that the velocity says was travelled while the position did not change (rad).
const TRAVELLED: f32 = 0.05;
/// Change of the asked torque, as a share of the largest, that no joint withstands without moving. A standing foot and
/// friction hold less.
const ASKED: f32 = 0.25;

/// Memory of one encoder.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Encoder {
    position: f32,
    /// Integral of the velocity since the position changed (rad). Noise cancels; a coarse encoder may stand still.
    travelled: f32,
    /// Target when the position last changed (rad).
    target: f32,
    /// Time for which the joint must have moved (s).
    suspect: f32,
}

impl Encoder {
    /// Returns the distance (rad) from the last position, and the largest that is possible within `dt` (s).
    pub(super) fn jump(&self, position: f32, limits: &JointLimits, dt: f32) -> (f32, f32) {
        ((position - self.position).abs(), limits.velocity * dt + SLACK)
    }

    /// Takes a measurement `dt` (s) after the last, with the target of now. Returns the time for which the position has
    /// been the same while the joint must have moved (s).
    pub(super) fn take(&mut self, position: f32, velocity: f32, target: f32, limits: &JointLimits, dt: f32) -> f32 {
        if position.to_bits() != self.position.to_bits() {
            self.begin(position, target);
            return 0.0;
        }
        self.travelled += velocity * dt;
        let asked = limits.kp * (target - self.target).abs();
        let must_move = self.travelled.abs() > TRAVELLED || asked > ASKED * limits.torque;
        self.suspect = if must_move { self.suspect + dt } else { 0.0 };
        self.suspect
    }

    /// Begins at a position.
    pub(super) fn begin(&mut self, position: f32, target: f32) {
        *self = Self { position, travelled: 0.0, target, suspect: 0.0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_encoder_that_repeats_itself_is_frozen_when_its_joint_must_move_only() {
        let limits = JointLimits {
            position: (-1.0, 1.0),
            rate: 1.0,
            acceleration: 1.0,
            torque: 20.0,
            torque_continuous: 10.0,
            kp: 10.0,
            kd: 0.0,
            velocity: 1.0,
        };
        let mut encoder = Encoder::default();
        encoder.begin(0.5, 0.5);
        // A joint that stands, with noise of its velocity: never.
        assert!((0..10_000).all(|i| encoder.take(0.5, if i % 2 == 0 { 0.1 } else { -0.1 }, 0.5, &limits, 1e-3) == 0.0));
        // 1 rad/s: 0.05 rad are travelled after 50 ms, and are suspect from then on.
        let suspect: Vec<f32> = (0..100).map(|_| encoder.take(0.5, 1.0, 0.5, &limits, 1e-3)).collect();
        assert!(suspect[48] == 0.0 && (0.048..0.053).contains(&suspect[99]), "{}", suspect[99]);
        assert_eq!(encoder.take(0.6, 1.0, 0.5, &limits, 1e-3), 0.0);
        // 10 N m/rad: 0.4 rad ask for 4 N m of 20, which friction may hold, and 0.7 rad for 7.
        assert!((0..1000).all(|_| encoder.take(0.6, 0.0, 0.9, &limits, 1e-3) == 0.0));
        let suspect = (0..10).map(|_| encoder.take(0.6, 0.0, 1.2, &limits, 1e-3)).last();
        assert!(suspect.is_some_and(|suspect| (suspect - 0.01).abs() < 1e-6));
    }
}
