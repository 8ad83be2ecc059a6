//! PD control without motor or friction, as many simulators have it.

use super::ActuatorParameters;
use super::models::{ActuatorModel, above_zero, at_least};

/// Velocity that no joint reaches: the simulation has diverged there (rad/s).
const UNREACHED: f64 = 1e3;

/// A PD controller whose torque is clamped: `clamp(kp (target - q) - kd v, ±torque_max)` at any velocity, without friction.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IdealPd {
    /// Proportional gain (N m/rad).
    pub kp: f64,
    /// Derivative gain (N m s/rad).
    pub kd: f64,
    /// Largest torque (N m).
    pub torque_max: f64,
}

impl ActuatorModel for IdealPd {
    const NAME: &'static str = "ideal-pd";

    fn law(&self) -> Result<ActuatorParameters, String> {
        at_least("kp", self.kp, 0.0)?;
        at_least("kd", self.kd, 0.0)?;
        above_zero("torque_max", self.torque_max)?;
        Ok(ActuatorParameters {
            kp: self.kp,
            kd: self.kd,
            friction_velocity: 1.0,
            static_friction: 0.0,
            viscous_friction: 0.0,
            torque_max: self.torque_max,
            full_torque_velocity: UNREACHED,
            velocity_max: 2.0 * UNREACHED,
            extended_friction: None,
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_law_is_a_clamped_pd_controller() {
        let pd = IdealPd { kp: 20.0, kd: 0.5, torque_max: 7.0 };
        let law = pd.law().unwrap();
        for velocity in [-900.0_f64, -30.0, -1.0, 0.0, 0.5, 30.0, 900.0] {
            for target in [-2.0, -0.1, 0.0, 0.3, 2.0] {
                let expected = (20.0 * (target - 0.1_f64) - 0.5 * velocity).clamp(-7.0, 7.0);
                assert_eq!(law.torque(target, 0.1, velocity), expected, "{target} {velocity}");
            }
        }
        assert_eq!(law.friction_damping(3.0), 0.0);
        assert!(
            IdealPd { torque_max: 0.0, ..pd }
                .law()
                .unwrap_err()
                .contains("torque_max: expected a number above 0, got 0")
        );
    }
}
