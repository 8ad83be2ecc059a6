//! A DC servo by its data sheet.

use super::ActuatorParameters;
use super::models::{ActuatorModel, above_zero, at_least};

/// A position servo with a DC motor behind a current limit: numbers of a data sheet, at the output of the gear.
///
/// The firmware commands the duty `clamp(proportional (target - q) - derivative v, ±duty_max)`, and the winding has the current
/// `clamp((duty supply - torque_constant v) / resistance, ±current_max)`. Up to the velocity without load this is eq. 4.11 with
/// κ_P = k V P / R, κ_D = k V D / R + k² / R, τ_max = k I, q̇_max = d V / k and q̇_τmax = q̇_max - R I / k. Beyond it the law has no
/// torque, where the motor would brake.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DcServo {
    /// Duty for an error of the position (1/rad).
    pub proportional: f64,
    /// Duty against a velocity (s/rad).
    #[serde(default)]
    pub derivative: f64,
    /// Largest duty.
    #[serde(default = "one")]
    pub duty_max: f64,
    /// Supply (V).
    pub supply: f64,
    /// Resistance of the winding (ohm).
    pub resistance: f64,
    /// Torque constant, which is also the back-EMF's (N m/A, V s/rad).
    pub torque_constant: f64,
    /// Largest current; that at stall where not given (A).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub current_max: Option<f64>,
    /// Static friction (N m).
    #[serde(default)]
    pub static_friction: f64,
    /// Activation velocity of static friction (rad/s).
    #[serde(default = "tenth")]
    pub friction_velocity: f64,
    /// Viscous friction (N m s/rad).
    #[serde(default)]
    pub viscous_friction: f64,
}

fn one() -> f64 {
    1.0
}

fn tenth() -> f64 {
    0.1
}

impl ActuatorModel for DcServo {
    const NAME: &'static str = "dc-servo";

    fn law(&self) -> Result<ActuatorParameters, String> {
        for (key, value) in
            [("supply", self.supply), ("resistance", self.resistance), ("torque_constant", self.torque_constant)]
        {
            above_zero(key, value)?;
        }
        at_least("proportional", self.proportional, 0.0)?;
        at_least("derivative", self.derivative, 0.0)?;
        if !(self.duty_max > 0.0 && self.duty_max <= 1.0) {
            return Err(format!("duty_max: expected a number above 0 and at most 1, got {}", self.duty_max));
        }
        let stall = self.duty_max * self.supply / self.resistance;
        let current = self.current_max.unwrap_or(stall);
        if !(current > 0.0 && current <= stall) {
            return Err(format!(
                "current_max: expected a number above 0 and at most {stall}, the current at stall, got {current}"
            ));
        }
        let volt = self.torque_constant / self.resistance;
        let velocity_max = self.duty_max * self.supply / self.torque_constant;
        Ok(ActuatorParameters {
            kp: volt * self.supply * self.proportional,
            kd: volt * (self.supply * self.derivative + self.torque_constant),
            friction_velocity: self.friction_velocity,
            static_friction: self.static_friction,
            viscous_friction: self.viscous_friction,
            torque_max: self.torque_constant * current,
            full_torque_velocity: (velocity_max - self.resistance * current / self.torque_constant).max(0.0),
            velocity_max,
            extended_friction: None,
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::actuator::DcMotor;

    const SERVO: DcServo = DcServo {
        proportional: 3.0,
        derivative: 0.05,
        duty_max: 0.9,
        supply: 12.0,
        resistance: 4.0,
        torque_constant: 1.1,
        current_max: Some(1.7),
        static_friction: 0.0,
        friction_velocity: 0.1,
        viscous_friction: 0.0,
    };

    /// The independent truth is [`DcMotor`]: Ohm's law with limits on duty and current.
    #[test]
    fn the_law_is_the_motor_of_the_data_sheet_up_to_the_velocity_without_load() {
        for current_max in [Some(1.7), None] {
            let servo = DcServo { current_max, ..SERVO };
            let law = servo.law().unwrap();
            let motor = DcMotor {
                proportional: servo.proportional,
                integral: 0.0,
                derivative: servo.derivative,
                duty_max: servo.duty_max,
                supply: servo.supply,
                supply_resistance: 0.0,
                resistance: servo.resistance,
                torque_constant: servo.torque_constant,
                current_max: law.torque_max / servo.torque_constant,
            };
            for step in -50..=50 {
                let velocity = 0.02 * f64::from(step) * law.velocity_max;
                for target in [-3.0, -0.4, -0.05, 0.0, 0.02, 0.3, 3.0] {
                    let expected = motor.drive(motor.duty(target, 0.0, velocity), velocity).torque;
                    let got = law.torque(target, 0.0, velocity);
                    assert!((got - expected).abs() < 1e-9, "{target} {velocity}: {got} {expected}");
                }
            }
        }
    }

    #[test]
    fn numbers_of_no_servo_are_named() {
        let told = |servo: DcServo| servo.law().unwrap_err();
        assert!(told(DcServo { current_max: Some(5.0), ..SERVO }).contains("at most 2.7, the current at stall, got 5"));
        assert!(told(DcServo { supply: 0.0, ..SERVO }).contains("supply: expected a number above 0, got 0"));
        assert!(told(DcServo { duty_max: 1.5, ..SERVO }).contains("duty_max"));
    }
}
