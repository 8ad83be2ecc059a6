//! Friction of geared servos: Coulomb, Stribeck and load (Duclusaud et al., "Extended Friction Models for the Physics
//! Simulation of Servo Actuators", 2024). Of the models M1 to M6 the smaller are the larger with zeros.

use lifelike_simd::Number;

use super::models::at_least;

/// Parameters of a friction. Each term is a torque that holds, or slows, against the motion.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ExtendedFriction<T = f64> {
    /// Torque at any velocity (N m): Coulomb's.
    pub base: T,
    /// Torque that is added at rest (N m): Stribeck's.
    pub stribeck: T,
    /// Velocity by which the terms at rest have faded (rad/s); they are left out where it is zero.
    pub stribeck_velocity: T,
    /// Steepness of their fading: exp(-|v / stribeck_velocity|^alpha).
    pub stribeck_exponent: T,
    /// Torque for each N m of the motor, and of what turns it from outside; their difference counts (gear teeth under load).
    pub load: [T; 2],
    /// The same, at rest only.
    pub load_stribeck: [T; 2],
    /// Torque at rest for each square of the motor's torque when it is driven backwards, and of the outer torque when
    /// it drives (1/(N m)).
    pub load_quadratic: [T; 2],
    /// Torque for a velocity (N m s/rad).
    pub viscous: T,
}

/// Names of [`ExtendedFriction::numbers`].
pub(crate) const NUMBERS: [&str; 11] = [
    "friction (N m)",
    "friction at rest (N m)",
    "velocity of friction at rest (rad/s)",
    "exponent of friction at rest",
    "friction by the motor's torque",
    "friction by the outer torque",
    "friction at rest by the motor's torque",
    "friction at rest by the outer torque",
    "friction at rest by the motor's squared torque (1/(N m))",
    "friction at rest by the squared outer torque (1/(N m))",
    "friction by velocity (N m s/rad)",
];

fn size<T: Number>(x: T) -> T {
    x.most(-x)
}

impl<T: Number> ExtendedFriction<T> {
    /// Returns the same parameters as other numbers.
    pub fn map<N>(&self, number: impl Fn(T) -> N) -> ExtendedFriction<N> {
        ExtendedFriction {
            base: number(self.base),
            stribeck: number(self.stribeck),
            stribeck_velocity: number(self.stribeck_velocity),
            stribeck_exponent: number(self.stribeck_exponent),
            load: self.load.map(&number),
            load_stribeck: self.load_stribeck.map(&number),
            load_quadratic: self.load_quadratic.map(&number),
            viscous: number(self.viscous),
        }
    }

    /// Returns the largest torque against the motion (N m) under the motor's torque, that from outside (N m), and a velocity
    /// (rad/s): what does not exceed it is held at rest.
    #[inline(always)]
    pub fn limit(&self, motor: T, outside: T, velocity: T) -> T {
        let zero = T::from_f64(0.0);
        let (load, load_at_rest) = (self.load, self.load_stribeck);
        let loaded = size(outside * load[1] - motor * load[0]);
        let limit = self.base + loaded + self.viscous * size(velocity);
        let ratio = size(velocity / self.stribeck_velocity.most(T::from_f64(1e-9)));
        let fade = (-ratio.powf(self.stribeck_exponent)).exp();
        let rest = self.stribeck + size(outside * load_at_rest[1] - motor * load_at_rest[0]);
        // Only against each other, and the smaller of the two holds.
        let [of_motor, of_outside] = self.load_quadratic;
        let driven = size(motor).select_gt(size(outside), of_outside * outside * outside, zero);
        let driving = size(outside).select_gt(size(motor), of_motor * motor * motor, zero);
        let square = (-(motor * outside)).select_gt(zero, driven + driving, zero);
        limit + self.stribeck_velocity.select_gt(zero, fade * (rest + square), zero)
    }
}

impl ExtendedFriction {
    /// Returns all parameters as one row, by the names of [`NUMBERS`].
    pub(crate) fn numbers(&self) -> [f64; 11] {
        let ([a, b], [c, d], [e, f]) = (self.load, self.load_stribeck, self.load_quadratic);
        [self.base, self.stribeck, self.stribeck_velocity, self.stribeck_exponent, a, b, c, d, e, f, self.viscous]
    }

    /// Checks whether the numbers can be a friction's beside a law that has its own term of velocity; says what is wrong.
    pub(crate) fn check(&self) -> Result<(), String> {
        for (name, number) in NUMBERS.iter().zip(self.numbers()) {
            at_least(name, number, 0.0)?;
        }
        if self.viscous != 0.0 {
            return Err(format!("viscous: expected 0, as viscous_friction stands beside it, got {}", self.viscous));
        }
        let [of_motor, of_outside] = self.load;
        if of_motor >= 1.0 || of_outside >= 1.0 {
            return Err(format!("load: expected shares below 1, got {of_motor} and {of_outside}"));
        }
        Ok(())
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
    fn single_precision_is_the_same_friction() {
        let narrow = M6.map(|x| x as f32);
        for motor in [-1.3, -0.2, 0.0, 0.4, 2.0] {
            for outside in [-2.0, -0.1, 0.0, 0.9] {
                for velocity in [-5.0, -1.0, -1e-3, 0.0, 0.3, 2.0, 40.0] {
                    let expected = M6.limit(motor, outside, velocity);
                    let got = narrow.limit(motor as f32, outside as f32, velocity as f32);
                    assert!((f64::from(got) - expected).abs() < 2e-5 * expected, "{motor} {outside} {velocity}");
                }
            }
        }
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
