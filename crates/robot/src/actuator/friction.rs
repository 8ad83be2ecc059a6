//! Friction of geared servos: Coulomb, Stribeck and load (Duclusaud et al., "Extended Friction Models for the Physics
//! Simulation of Servo Actuators", 2024). Of the models M1 to M6 the smaller are the larger with zeros.

/// Parameters of a friction. Each term is a torque that holds, or slows, against the motion.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ExtendedFriction {
    /// Torque at any velocity (N m): Coulomb's.
    pub base: f64,
    /// Torque that is added at rest (N m): Stribeck's.
    pub stribeck: f64,
    /// Velocity by which the terms at rest have faded (rad/s).
    pub stribeck_velocity: f64,
    /// Steepness of their fading: exp(-|v / stribeck_velocity|^alpha).
    pub stribeck_exponent: f64,
    /// Torque for each N m of the motor, and of what turns it from outside; their difference counts (gear teeth under load).
    pub load: [f64; 2],
    /// The same, at rest only.
    pub load_stribeck: [f64; 2],
    /// Torque at rest for each square of the motor's torque when it is driven backwards, and of the outer torque when
    /// it drives (1/(N m)).
    pub load_quadratic: [f64; 2],
    /// Torque for a velocity (N m s/rad).
    pub viscous: f64,
}

impl ExtendedFriction {
    /// Returns the largest torque against the motion (N m) under the motor's torque, that from outside (N m), and a velocity
    /// (rad/s): what does not exceed it is held at rest.
    pub fn limit(&self, motor: f64, outside: f64, velocity: f64) -> f64 {
        let difference = |[m, o]: [f64; 2]| (outside * o - motor * m).abs();
        let mut limit = self.base + difference(self.load) + self.viscous * velocity.abs();
        if self.stribeck_velocity > 0.0 {
            let fade = (-(velocity / self.stribeck_velocity).abs().powf(self.stribeck_exponent)).exp();
            let mut rest = self.stribeck + difference(self.load_stribeck);
            if motor * outside < 0.0 || (motor == 0.0) != (outside == 0.0) {
                let [of_motor, of_outside] = self.load_quadratic;
                if outside.abs() < motor.abs() {
                    rest += of_outside * outside * outside;
                } else if outside.abs() > motor.abs() {
                    rest += of_motor * motor * motor;
                }
            }
            limit += fade * rest;
        }
        limit
    }

    /// Returns the torque of the friction (N m) over a step: it opposes what would move an inertia (kg m²), up to its limit, and
    /// never turns the motion round.
    pub fn torque(&self, motor: f64, outside: f64, velocity: f64, inertia: f64, step: f64) -> f64 {
        let stop = inertia / step * velocity + motor + outside;
        -stop.signum() * stop.abs().min(self.limit(motor, outside, velocity))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const M6: ExtendedFriction = ExtendedFriction {
        base: 0.1,
        stribeck: 0.2,
        stribeck_velocity: 2.0,
        stribeck_exponent: 1.5,
        load: [0.3, 0.1],
        load_stribeck: [0.05, 0.02],
        load_quadratic: [0.4, 0.5],
        viscous: 0.01,
    };

    #[test]
    fn every_term_is_there() {
        // At rest, motor 1 N m against 0.5 N m: 0.1 + |0.05·(-1)... each by hand.
        let load = (-0.5_f64 * 0.1 - 0.3).abs();
        let rest = 0.2 + (-0.5_f64 * 0.02 - 0.05).abs() + 0.5 * 0.25;
        assert!((M6.limit(1.0, -0.5, 0.0) - (0.1 + load + rest)).abs() < 1e-12);
        // Moving, both the same way: nothing quadratic, Stribeck faded.
        let fade = (-(3.0_f64 / 2.0).powf(1.5)).exp();
        let load = (0.5_f64 * 0.1 - 0.3).abs();
        let rest = 0.2 + (0.5_f64 * 0.02 - 0.05).abs();
        assert!((M6.limit(1.0, 0.5, -3.0) - (0.1 + load + 0.03 + fade * rest)).abs() < 1e-12);
    }

    #[test]
    fn friction_holds_what_is_below_its_limit_and_slows_what_is_above() {
        let coulomb = ExtendedFriction { base: 0.2, ..ExtendedFriction::default() };
        assert_eq!(coulomb.torque(0.15, 0.0, 0.0, 0.01, 0.005), -0.15);
        assert_eq!(coulomb.torque(0.5, 0.0, 0.0, 0.01, 0.005), -0.2);
        assert_eq!(coulomb.torque(0.0, 0.0, -1.0, 0.01, 0.005), 0.2);
        // A slow motion is stopped, not turned round: 0.01 / 0.005 · 0.05 = 0.1.
        assert!((coulomb.torque(0.0, 0.0, 0.05, 0.01, 0.005) + 0.1).abs() < 1e-12);
    }
}
