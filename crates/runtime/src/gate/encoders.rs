//! Encoders that jump or freeze.

use super::limits::JointLimits;

/// Angle that an encoder may move beyond what its velocity allows (rad).
const SLACK: f32 = 0.1;
/// Angle that the velocity says was travelled while the position did not change (rad).
const TRAVELLED: f32 = 0.05;
/// Angle that the target moved while the position did not change (rad).
const ASKED: f32 = 0.2;

/// Memory of one encoder.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Encoder {
    position: f32,
    /// Time with the same position (s).
    same: f32,
    /// Integral of the speed in that time (rad).
    travelled: f32,
    /// Target when the position last changed (rad).
    target: f32,
}

impl Encoder {
    /// Returns the distance (rad) from the last position, and the largest that is possible within `dt` (s).
    pub(super) fn jump(&self, position: f32, limits: &JointLimits, dt: f32) -> (f32, f32) {
        ((position - self.position).abs(), limits.velocity * dt + SLACK)
    }

    /// Takes a measurement `dt` (s) after the last, with the target of now. Returns the time for which the position has
    /// been the same while the joint must have moved (s).
    pub(super) fn take(&mut self, position: f32, velocity: f32, target: f32, dt: f32) -> f32 {
        if position.to_bits() != self.position.to_bits() {
            *self = Self { position, same: 0.0, travelled: 0.0, target };
            return 0.0;
        }
        self.same += dt;
        self.travelled += velocity.abs() * dt;
        let must_move = self.travelled > TRAVELLED || (target - self.target).abs() > ASKED;
        if must_move { self.same } else { 0.0 }
    }

    /// Forgets that the position was the same.
    pub(super) fn begin(&mut self, position: f32, target: f32) {
        *self = Self { position, same: 0.0, travelled: 0.0, target };
    }
}
