//! A servo with the parameters that Rhoban's BAM identifies.

use super::friction::ExtendedFriction;
use super::models::{ActuatorModel, above_zero, at_least};
use super::{ActuatorParameters, DcServo};

/// A position servo by the numbers of a parameter file of BAM (github.com/Rhoban/bam, models M1 to M6).
///
/// The models are those of Duclusaud et al., "Extended Friction Models for the Physics Simulation of Servo Actuators" (2024).
/// The keys are those of the file, so its JSON is the table. Three more say how the servo is used: the firmware's gain `kp`, the
/// supply `vin`, and `error_gain`, the duty for a radian and a gain of one. The motor is that of [`DcServo`] with `kp error_gain`
/// as `proportional`; friction is [`ExtendedFriction`].
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bam {
    /// Gain of the firmware.
    pub kp: f64,
    /// Supply (V).
    pub vin: f64,
    /// Duty for an error of the position, at a gain of one (1/rad).
    pub error_gain: f64,
    /// Largest duty.
    #[serde(default = "one")]
    pub max_pwm: f64,
    /// Largest current that the firmware allows; that at stall where not given (A).
    #[serde(default)]
    pub max_current: Option<f64>,
    /// Torque constant, which is also the back-EMF's (N m/A, V s/rad).
    pub kt: f64,
    /// Resistance of the winding (ohm).
    #[serde(rename = "R")]
    pub resistance: f64,
    /// Inertia of the rotor through its gear (kg m²); the group's `armature` goes before it.
    pub armature: f64,
    /// Coulomb friction (N m).
    pub friction_base: f64,
    /// Viscous friction (N m s/rad).
    pub friction_viscous: f64,
    /// Friction added at rest (N m): M2, M4 to M6.
    #[serde(default)]
    pub friction_stribeck: f64,
    /// Velocity by which friction at rest fades (rad/s).
    #[serde(default)]
    pub dtheta_stribeck: f64,
    /// Exponent of the fading.
    #[serde(default)]
    pub alpha: f64,
    /// Friction by the load, in both directions (M3, M4).
    #[serde(default)]
    pub load_friction_base: f64,
    /// The same at rest (M4).
    #[serde(default)]
    pub load_friction_stribeck: f64,
    /// Friction by the motor's torque (M5, M6).
    #[serde(default)]
    pub load_friction_motor: f64,
    /// Friction by the outer torque (M5, M6).
    #[serde(default)]
    pub load_friction_external: f64,
    /// Friction at rest by the motor's torque (M5, M6).
    #[serde(default)]
    pub load_friction_motor_stribeck: f64,
    /// Friction at rest by the outer torque (M5, M6).
    #[serde(default)]
    pub load_friction_external_stribeck: f64,
    /// Friction at rest by the motor's squared torque (M6; 1/(N m)).
    #[serde(default)]
    pub load_friction_motor_quad: f64,
    /// Friction at rest by the squared outer torque (M6; 1/(N m)).
    #[serde(default)]
    pub load_friction_external_quad: f64,
    /// Offset of the bench that identified it (rad): not used.
    #[serde(default)]
    pub q_offset: f64,
    /// Name of the model in the file: `m1` to `m6`.
    #[serde(default)]
    pub model: Option<String>,
    /// Name of the servo in the file.
    #[serde(default)]
    pub actuator: Option<String>,
}

fn one() -> f64 {
    1.0
}

impl Bam {
    fn friction(&self) -> ExtendedFriction {
        // One share for both directions is the same for motor and outside.
        let (both, both_at_rest) = (self.load_friction_base, self.load_friction_stribeck);
        ExtendedFriction {
            base: self.friction_base,
            stribeck: self.friction_stribeck,
            stribeck_velocity: self.dtheta_stribeck,
            stribeck_exponent: self.alpha,
            load: [self.load_friction_motor + both, self.load_friction_external + both],
            load_stribeck: [
                self.load_friction_motor_stribeck + both_at_rest,
                self.load_friction_external_stribeck + both_at_rest,
            ],
            load_quadratic: [self.load_friction_motor_quad, self.load_friction_external_quad],
            viscous: 0.0,
        }
    }
}

impl ActuatorModel for Bam {
    const NAME: &'static str = "bam";

    fn law(&self) -> Result<ActuatorParameters, String> {
        for (key, value) in [("vin", self.vin), ("kt", self.kt), ("R", self.resistance)] {
            above_zero(key, value)?;
        }
        for (key, value) in [("kp", self.kp), ("error_gain", self.error_gain), ("armature", self.armature)] {
            at_least(key, value, 0.0)?;
        }
        let servo = DcServo {
            proportional: self.kp * self.error_gain,
            derivative: 0.0,
            duty_max: self.max_pwm,
            supply: self.vin,
            resistance: self.resistance,
            torque_constant: self.kt,
            current_max: self.max_current,
            static_friction: 0.0,
            friction_velocity: 1.0,
            viscous_friction: self.friction_viscous,
        };
        Ok(ActuatorParameters { extended_friction: Some(self.friction()), ..servo.law()? })
    }

    fn armature(&self) -> Option<f64> {
        Some(self.armature)
    }
}
