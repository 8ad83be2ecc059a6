//! The actuator model of thesis eqs. 4.9-4.11, generic over the number type: scalar f32/f64 now, SIMD lanes later.

use nalgebra::RealField;

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
}

impl<T: RealField + Copy> ActuatorParameters<T> {
    /// The motor's torque: eq. 4.9 (PD), clamped as in eq. 4.11. Braking has the full torque at any velocity; driving
    /// ramps down linearly from `full_torque_velocity` to zero at `velocity_max`.
    pub fn motor_torque(&self, target: T, position: T, velocity: T) -> T {
        self.clamp(self.kp * (target - position) - self.kd * velocity, velocity)
    }

    /// The velocity-dependent clamp of eq. 4.11.
    pub fn clamp(&self, torque: T, velocity: T) -> T {
        let ramp = |v: T| {
            ((self.velocity_max - v) / (self.velocity_max - self.full_torque_velocity)).clamp(T::zero(), T::one())
        };
        torque.min(self.torque_max * ramp(velocity)).max(-self.torque_max * ramp(-velocity))
    }

    /// The frictional torque of eq. 4.10.
    pub fn friction_torque(&self, velocity: T) -> T {
        self.static_friction * (velocity / self.friction_velocity).tanh() + self.viscous_friction * velocity
    }

    /// Friction as a damping coefficient: `friction_torque(v) / v`, finite at v = 0. Integrated implicitly at the current
    /// velocity it equals eq. 4.10 to first order in the time step and is stable for any step, where the explicit form
    /// is not: `μ_s / q̇_s · dt` exceeds twice the inertia of a light ankle at dt = 5 ms.
    pub fn friction_damping(&self, velocity: T) -> T {
        let x = velocity / self.friction_velocity;
        let slope = if x.abs() < nalgebra::convert(1e-4) { T::one() } else { x.tanh() / x };
        self.static_friction / self.friction_velocity * slope + self.viscous_friction
    }

    /// Joint torque: eq. 4.11 whole, motor less friction.
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
