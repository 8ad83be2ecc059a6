//! A brushed DC motor behind a position controller: the electrical half of thesis 2.3.1.

/// A servo's position controller and its motor. The inductance is left out: its time constant is far below a step.
///
/// Beside eqs. 4.9 to 4.11, which is what simulations evaluate, this says which voltage and current a torque takes, and so what
/// a servo's own sensors see.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DcMotor {
    /// Duty for an error of the position (1/rad).
    pub proportional: f64,
    /// Duty for the error's integral (1/(rad s)).
    #[serde(default)]
    pub integral: f64,
    /// Duty against a velocity (s/rad).
    #[serde(default)]
    pub derivative: f64,
    /// Largest duty, at most 1.
    pub duty_max: f64,
    /// Supply (V).
    pub supply: f64,
    /// Resistance of supply and cables (ohm): the voltage sags by it times the supply's current, which is duty times the motor's.
    #[serde(default)]
    pub supply_resistance: f64,
    /// Resistance of the winding (ohm).
    pub resistance: f64,
    /// Torque constant at the output (N m/A), which is also the back-EMF's (V s/rad).
    pub torque_constant: f64,
    /// Largest current (A).
    #[serde(default = "unlimited", skip_serializing_if = "is_unlimited")]
    pub current_max: f64,
}

fn unlimited() -> f64 {
    f64::INFINITY
}

fn is_unlimited(x: &f64) -> bool {
    x.is_infinite()
}

/// State of a motor at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotorState {
    /// Voltage on the winding (V).
    pub voltage: f64,
    /// Current through it (A).
    pub current: f64,
    /// Torque at the output, before friction (N m).
    pub torque: f64,
}

impl DcMotor {
    /// Returns the duty (-1 to 1) for an error, its integral (rad s) and a velocity (rad/s).
    pub fn duty(&self, error: f64, integral: f64, velocity: f64) -> f64 {
        let duty = self.proportional * error + self.integral * integral - self.derivative * velocity;
        duty.clamp(-self.duty_max, self.duty_max)
    }

    /// Returns what the motor does with a duty at a velocity (rad/s).
    pub fn drive(&self, duty: f64, velocity: f64) -> MotorState {
        let back = self.torque_constant * velocity;
        // V = d (supply - r d I) and I = (V - back) / R, solved for I.
        let free = (duty * self.supply - back) / (self.resistance + self.supply_resistance * duty * duty);
        let current = free.clamp(-self.current_max, self.current_max);
        MotorState { voltage: current * self.resistance + back, current, torque: self.torque_constant * current }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOTOR: DcMotor = DcMotor {
        proportional: 2.0,
        integral: 0.5,
        derivative: 0.1,
        duty_max: 0.9,
        supply: 10.0,
        supply_resistance: 0.0,
        resistance: 4.0,
        torque_constant: 0.5,
        current_max: f64::INFINITY,
    };

    #[test]
    fn duty_is_a_pid_with_a_limit() {
        assert!((MOTOR.duty(0.2, 0.4, 1.0) - (0.4 + 0.2 - 0.1)).abs() < 1e-12);
        assert_eq!((MOTOR.duty(9.0, 0.0, 0.0), MOTOR.duty(-9.0, 0.0, 0.0)), (0.9, -0.9));
    }

    #[test]
    fn voltage_current_and_torque_obey_ohm_and_the_back_emf() {
        // (0.5 · 10 V - 0.5 · 2 V) / 4 ohm = 1 A
        assert_eq!(MOTOR.drive(0.5, 2.0), MotorState { voltage: 5.0, current: 1.0, torque: 0.5 });
        // At the speed whose back-EMF is the voltage, nothing is left.
        assert_eq!(MOTOR.drive(0.5, 10.0).torque, 0.0);
        let limited = DcMotor { current_max: 0.4, ..MOTOR }.drive(0.5, 2.0);
        assert_eq!(limited, MotorState { voltage: 2.6, current: 0.4, torque: 0.2 });
    }

    #[test]
    fn a_supply_with_a_resistance_sags() {
        let motor = DcMotor { supply_resistance: 1.0, ..MOTOR };
        let state = motor.drive(0.8, 0.0);
        let supply = motor.supply - 1.0 * 0.8 * state.current;
        assert!((state.voltage - 0.8 * supply).abs() < 1e-12 && supply < 10.0, "{state:?} {supply}");
    }
}
