//! The actuator model of thesis eqs. 4.9-4.11, generic over the number type: one robot's, or a vector of many. Beside it what
//! chapter 2 needs of real servos: the motor's electricity and friction as it was measured.

mod bam;
mod dc_servo;
pub(crate) mod friction;
mod ideal_pd;
pub(crate) mod models;
mod motor;

pub use bam::Bam;
pub use dc_servo::DcServo;
pub use friction::ExtendedFriction;
pub use ideal_pd::IdealPd;
pub use models::{ActuatorModel, MODELS};
pub use motor::{DcMotor, MotorState};

use lifelike_simd::Number;

/// Parameters of one actuator (Table 4.1).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ActuatorParameters<T = f64> {
    /// Proportional gain κ_P (N m/rad).
    pub kp: T,
    /// Derivative gain κ_D (N m s/rad).
    pub kd: T,
    /// Activation velocity of static friction q̇_s (rad/s).
    pub friction_velocity: T,
    /// Static (Coulomb) friction μ_s (N m).
    pub static_friction: T,
    /// Viscous friction μ_d (N m s/rad).
    pub viscous_friction: T,
    /// Largest torque τ_max (N m).
    pub torque_max: T,
    /// Velocity up to which the largest torque is available q̇_τmax (rad/s).
    pub full_torque_velocity: T,
    /// Velocity at which no torque is left q̇_max (rad/s).
    pub velocity_max: T,
    /// Dry friction beside that of eq. 4.10, which depends on the load; engines hold it as MuJoCo holds `frictionloss`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extended_friction: Option<ExtendedFriction>,
}

impl<T: Number> ActuatorParameters<T> {
    /// Returns the same parameters as other numbers.
    pub fn map<N>(&self, number: impl Fn(T) -> N) -> ActuatorParameters<N> {
        ActuatorParameters {
            kp: number(self.kp),
            kd: number(self.kd),
            friction_velocity: number(self.friction_velocity),
            static_friction: number(self.static_friction),
            viscous_friction: number(self.viscous_friction),
            torque_max: number(self.torque_max),
            full_torque_velocity: number(self.full_torque_velocity),
            velocity_max: number(self.velocity_max),
            extended_friction: self.extended_friction,
        }
    }

    /// Returns the motor's torque: eq. 4.9 (PD), clamped as in eq. 4.11. Braking has the full torque at any velocity;
    /// driving ramps down linearly from `full_torque_velocity` to zero at `velocity_max`.
    #[inline(always)]
    pub fn motor_torque(&self, target: T, position: T, velocity: T) -> T {
        self.motor_torque_with([self.kp, self.kd], target, position, velocity)
    }

    /// As [`Self::motor_torque`] with other gains κ_P and κ_D.
    #[inline(always)]
    pub fn motor_torque_with(&self, [kp, kd]: [T; 2], target: T, position: T, velocity: T) -> T {
        self.clamp(kp * (target - position) - kd * velocity, velocity)
    }

    /// Returns the velocity-dependent clamp of eq. 4.11.
    #[inline(always)]
    pub fn clamp(&self, torque: T, velocity: T) -> T {
        let (zero, one) = (T::from_f64(0.0), T::from_f64(1.0));
        let ramp =
            |v: T| ((self.velocity_max - v) / (self.velocity_max - self.full_torque_velocity)).most(zero).least(one);
        torque.least(self.torque_max * ramp(velocity)).most(-self.torque_max * ramp(-velocity))
    }

    /// Returns the frictional torque of eq. 4.10.
    #[inline(always)]
    pub fn friction_torque(&self, velocity: T) -> T {
        self.static_friction * (velocity / self.friction_velocity).tanh() + self.viscous_friction * velocity
    }

    /// Returns the friction as a damping coefficient: `friction_torque(v) / v`, finite at v = 0. Integrated implicitly
    /// at the current velocity it equals eq. 4.10 to first order in the time step and is stable for any step, where the
    /// explicit form is not: `μ_s / q̇_s · dt` exceeds twice the inertia of a light ankle at dt = 5 ms.
    #[inline(always)]
    pub fn friction_damping(&self, velocity: T) -> T {
        let slope = (velocity / self.friction_velocity).tanh_ratio();
        self.static_friction / self.friction_velocity * slope + self.viscous_friction
    }

    /// Returns the joint torque: eq. 4.11 whole, motor less friction.
    #[inline(always)]
    pub fn torque(&self, target: T, position: T, velocity: T) -> T {
        self.motor_torque(target, position, velocity) - self.friction_torque(velocity)
    }
}

/// One actuator per scalar joint, by name, in the character's joint order.
#[derive(Debug, Clone, PartialEq)]
pub struct ActuatorSet {
    /// Joint names.
    pub joints: Vec<String>,
    /// Their actuators.
    pub parameters: Vec<ActuatorParameters>,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Unitree A1 of Table 4.1.
    const A1: ActuatorParameters = ActuatorParameters {
        kp: 15.0,
        kd: 0.6,
        friction_velocity: 0.1,
        static_friction: 0.45,
        viscous_friction: 0.023,
        torque_max: 34.0,
        full_torque_velocity: 7.4,
        velocity_max: 20.0,
        extended_friction: None,
    };

    #[test]
    fn the_motor_is_a_pd_controller_below_its_limits() {
        // 15 (1.0 - 0.2) - 0.6 · 2 = 12 - 1.2
        assert!((A1.motor_torque(1.0, 0.2, 2.0) - 10.8).abs() < 1e-12);
    }

    #[test]
    fn the_clamp_takes_every_branch_of_equation_4_11() {
        let cases = [
            // torque, velocity, expected
            (100.0, 0.0, 34.0),     // at rest: the largest torque
            (-100.0, 0.0, -34.0),   //
            (100.0, 7.4, 34.0),     // up to the limit velocity: still all of it
            (100.0, 13.7, 17.0),    // half way from 7.4 to 20: half
            (100.0, 20.0, 0.0),     // at the largest velocity: none
            (100.0, 25.0, 0.0),     // beyond it: none, never the wrong sign
            (-100.0, 13.7, -34.0),  // braking has the full torque ...
            (-100.0, 25.0, -34.0),  // ... at any velocity
            (-100.0, -13.7, -17.0), // and all of it mirrored
            (-100.0, -25.0, 0.0),   //
            (100.0, -25.0, 34.0),   //
            (5.0, 13.7, 5.0),       // inside the limits: untouched
            (-5.0, -13.7, -5.0),    //
        ];
        for (torque, velocity, expected) in cases {
            let got = A1.clamp(torque, velocity);
            assert!((got - expected).abs() < 1e-12, "clamp({torque}, {velocity}) = {got}, expected {expected}");
            assert_eq!(A1.clamp(-torque, -velocity), -got, "mirrored");
        }
    }

    #[test]
    fn friction_is_coulomb_and_viscous() {
        // 0.45 tanh(0.05 / 0.1) + 0.023 · 0.05, with tanh(0.5) = 0.46211715726000975
        assert!((A1.friction_torque(0.05) - (0.45 * 0.462_117_157_260_009_75 + 0.001_15)).abs() < 1e-15);
        assert!((A1.friction_torque(10.0) - 0.68).abs() < 1e-12, "saturated: 0.45 + 0.23");
        assert_eq!(A1.torque(1.0, 0.2, 2.0), A1.motor_torque(1.0, 0.2, 2.0) - A1.friction_torque(2.0));
    }

    #[test]
    fn friction_as_damping_is_the_same_torque() {
        for exponent in -80..20 {
            for sign in [-1.0, 1.0] {
                let v = sign * 10.0_f64.powf(f64::from(exponent) * 0.1);
                let (expected, got) = (A1.friction_torque(v), A1.friction_damping(v) * v);
                assert!((got - expected).abs() <= 1e-8 * expected.abs(), "v = {v}: {got} against {expected}");
            }
        }
        assert_eq!(A1.friction_damping(0.0), 0.45 / 0.1 + 0.023);
    }

    #[test]
    fn single_precision_is_the_same_law() {
        let a1 = A1.map(|x| x as f32);
        for (target, position, velocity) in [(1.0, 0.2, 2.0), (3.0, -1.0, 13.7), (-3.0, 1.0, 13.7), (0.0, 0.0, -19.0)] {
            let expected = A1.torque(f64::from(target), f64::from(position), f64::from(velocity));
            assert!((f64::from(a1.torque(target, position, velocity)) - expected).abs() < 1e-5);
        }
    }
}
