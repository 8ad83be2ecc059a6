//! Speed, acceleration and range of one joint's target.

use super::limits::JointLimits;

/// A target on its way: it stops within its range at any time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Limiter {
    /// Present target (rad).
    pub(super) position: f32,
    /// Its speed over the last tick (rad/s).
    pub(super) speed: f32,
}

impl Limiter {
    /// Begins at rest at a position, within the range.
    pub(super) fn begin(&mut self, position: f32, limits: &JointLimits) {
        *self = Self { position: position.clamp(limits.position.0, limits.position.1), speed: 0.0 };
    }

    /// Moves towards a goal (rad) for a tick of `dt` (s), no faster than `rate` (rad/s), and returns the target.
    ///
    /// A speed v can be stopped within a distance d when `(v + a dt / 2)² <= 2 a d`: braking by `a dt` a tick, and not at
    /// ticks that fit. The next speed satisfies this for the goal and for both ends of the range.
    pub(super) fn step(&mut self, goal: f32, rate: f32, limits: &JointLimits, dt: f32) -> f32 {
        let (low, high) = limits.position;
        let (acceleration, goal) = (limits.acceleration, goal.clamp(low, high));
        let change = acceleration * dt;
        let stoppable = |distance: f32| ((2.0 * acceleration * distance.max(0.0)).sqrt() - 0.5 * change).max(0.0);
        let distance = goal - self.position;
        // The last bit of the way takes one tick.
        let brisk = stoppable(distance.abs()).max(change.min(distance.abs() / dt)).min(distance.abs() / dt);
        let wanted = brisk.min(rate.min(limits.rate)).copysign(distance);
        let (down, up) = (stoppable(self.position - low), stoppable(high - self.position));
        let reachable = wanted.clamp(self.speed - change, self.speed + change);
        self.speed = reachable.clamp(-down, up).clamp(-limits.rate, limits.rate);
        self.position = (self.position + self.speed * dt).clamp(low, high);
        self.position
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: JointLimits = JointLimits {
        position: (-1.0, 0.5),
        rate: 3.0,
        acceleration: 200.0,
        torque: 1.0,
        torque_continuous: 1.0,
        kp: 1.0,
        kd: 0.0,
        velocity: 1.0,
    };
    const DT: f32 = 1e-3;

    #[test]
    fn a_target_arrives_and_stays() {
        let mut limiter = Limiter::default();
        // 0.4 rad at 3 rad/s, and 15 ms each for getting there and back: 0.4 / 3 + 0.015 s.
        let ticks = (1..1000).find(|_| (limiter.step(0.4, 9.0, &LIMITS, DT) - 0.4).abs() < 1e-6);
        assert!((145..160).contains(&ticks.unwrap_or(0)), "{ticks:?}");
        (0..100).for_each(|_| assert!((limiter.step(0.4, 9.0, &LIMITS, DT) - 0.4).abs() < 1e-6));
    }

    #[test]
    fn whatever_is_asked_the_limits_hold() {
        let mut limiter = Limiter::default();
        let mut seed = 1u32;
        for tick in 0..200_000 {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            // Held for a while, so that targets move at full speed towards both ends.
            let goal = if (tick / 97) % 2 == 0 { 4.0 } else { -4.0 } * (seed >> 8) as f32 / 16_777_216.0;
            let before = limiter;
            let position = limiter.step(goal, 9.0, &LIMITS, DT);
            assert!((-1.0..=0.5).contains(&position));
            assert!(limiter.speed.abs() <= 3.0);
            let acceleration = (limiter.speed - before.speed).abs() / DT;
            assert!(acceleration <= 200.1, "tick {tick}: {acceleration} rad/s²");
            assert!((position - before.position).abs() <= 3.0 * DT + 1e-6);
        }
    }
}
