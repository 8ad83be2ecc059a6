//! Heat of the motors, modelled and measured, and the torque that is left.

use super::limits::JointLimits;

/// Share of the continuous rating at which torque begins to be reduced.
const DERATE_FROM: f32 = 0.8;
/// Torque that is left at the continuous rating, as a share of the continuous torque.
const LEFT: f32 = 0.95;
/// Heat at which the gate trips: a motor that does not obey.
pub(super) const TRIP: f32 = 1.3;

/// First-order heat of one motor: `du/dt = ((torque / continuous)² - u) / time constant`. 1 is the steady state of the
/// continuous torque.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Heat(pub(super) f32);

impl Heat {
    /// Adds `dt / time constant` of a torque.
    pub(super) fn add(&mut self, torque: f32, continuous: f32, share: f32) {
        let power = (torque / continuous.max(1e-6)).powi(2);
        if power.is_finite() {
            self.0 += (power - self.0) * share.min(1.0);
        }
    }

    /// Returns the largest torque that is allowed now (N m): the peak when cold, below the continuous one when hot.
    pub(super) fn allowed(self, limits: &JointLimits, temperature: f32, derate: f32, max: f32) -> f32 {
        let continuous = LEFT * limits.torque_continuous;
        let hot = ((self.0 - DERATE_FROM) / (1.0 - DERATE_FROM)).clamp(0.0, 1.0);
        let modelled = limits.torque + (continuous.min(limits.torque) - limits.torque) * hot;
        // NaN where nothing is measured: nothing is taken off.
        let measured = if temperature > derate { ((max - temperature) / (max - derate)).max(0.0) } else { 1.0 };
        modelled.min(measured * limits.torque)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits() -> JointLimits {
        JointLimits {
            position: (-1.0, 1.0),
            rate: 1.0,
            acceleration: 1.0,
            torque: 30.0,
            torque_continuous: 10.0,
            kp: 1.0,
            kd: 0.0,
            velocity: 1.0,
        }
    }

    #[test]
    fn heat_approaches_the_square_of_the_load() {
        let mut heat = Heat::default();
        (0..1000).for_each(|_| heat.add(5.0, 10.0, 1e-3));
        // 1000 steps of a thousandth: one time constant, 1 - 1/e of a quarter.
        assert!((heat.0 - 0.25 * (1.0 - (-1.0f32).exp())).abs() < 1e-3, "{heat:?}");
    }

    #[test]
    fn torque_falls_from_the_peak_to_less_than_the_continuous_one() {
        let allowed = |u: f32, t: f32| Heat(u).allowed(&limits(), t, 70.0, 90.0);
        assert_eq!((allowed(0.0, f32::NAN), allowed(0.8, 20.0)), (30.0, 30.0));
        assert!((allowed(0.9, f32::NAN) - 19.75).abs() < 1e-4, "half way from 30 to 9.5");
        assert!((allowed(1.0, f32::NAN) - 9.5).abs() < 1e-5 && (allowed(5.0, f32::NAN) - 9.5).abs() < 1e-5);
        assert_eq!((allowed(0.0, 80.0), allowed(0.0, 90.0), allowed(0.0, 120.0)), (15.0, 0.0, 0.0));
    }

    #[test]
    fn a_motor_that_is_asked_for_everything_stays_below_its_rating() {
        let mut heat = Heat::default();
        for _ in 0..1_000_000 {
            let torque = heat.allowed(&limits(), f32::NAN, 70.0, 90.0);
            heat.add(torque, 10.0, 1e-3 / 60.0);
        }
        assert!(heat.0 < 1.0 && heat.0 > 0.9, "{heat:?}");
    }
}
