//! One servo's firmware, motor, gear and encoder over a physics step.

use super::spec::TwinServo;

/// The side of a servo that the engine does not simulate.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DriveTrain {
    /// Angle of the rotor, at the output (rad).
    pub angle: f64,
    /// Its velocity (rad/s).
    pub velocity: f64,
    /// Torque on the part (N m).
    pub torque: f64,
    /// Current through the winding (A).
    pub current: f64,
    /// Voltage on it (V).
    pub voltage: f64,
    /// Current drawn from the supply (A).
    pub drawn: f64,
    /// The encoder's reading (rad).
    pub encoder: f64,
}

/// Surroundings of a servo at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Around {
    /// Target of the firmware (rad).
    pub target: f64,
    /// Angle of the part (rad).
    pub part: f64,
    /// Its velocity (rad/s).
    pub part_velocity: f64,
    /// Supply (V).
    pub supply: f64,
    /// Factor on the proportional gain.
    pub gain: f64,
    /// Factor on the motor's torque.
    pub strength: f64,
    /// Step of the encoder (rad).
    pub tick: f64,
}

impl DriveTrain {
    /// A servo that rests at a part's angle.
    pub fn at(angle: f64) -> Self {
        Self { angle, encoder: angle, ..Self::default() }
    }

    /// Takes a step of `dt` s. Returns the torque on the part (N m).
    pub fn step(&mut self, servo: &TwinServo, around: &Around, dt: f64) -> f64 {
        let &Around { target, part, part_velocity, supply, gain, strength, tick } = around;
        let gap = self.angle - part;
        let turn = gap - gap.clamp(-servo.play, servo.play);
        self.torque = match turn == 0.0 {
            true => 0.0,
            // Teeth push and never pull.
            false => {
                let torque = servo.stiffness * turn + servo.damping * (self.velocity - part_velocity);
                if torque * turn > 0.0 { torque } else { 0.0 }
            }
        };
        self.encoder = ((part + self.torque * servo.link_compliance) / tick).round() * tick;
        let mut motor = servo.motor;
        motor.proportional *= gain;
        motor.supply = supply;
        let duty = motor.duty(target - self.encoder, 0.0, self.velocity);
        let state = motor.drive(duty, self.velocity);
        (self.current, self.voltage, self.drawn) = (state.current, state.voltage, (duty * state.current).abs());
        let driven = strength * state.torque;
        let friction = servo.friction.torque(driven, -self.torque, self.velocity, servo.rotor, dt);
        self.velocity += dt / servo.rotor * (driven - self.torque + friction);
        self.angle += dt * self.velocity;
        self.torque
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_robot::Robot;

    use super::*;
    use crate::twin::TwinSpec;

    fn servo(spec: &TwinSpec) -> TwinServo {
        let robot = Robot::load("lima").unwrap();
        spec.servo("knee", &robot.actuators.parameters[0], 0.01)
    }

    const HELD: Around =
        Around { target: 0.0, part: 0.0, part_velocity: 0.0, supply: 12.0, gain: 1.0, strength: 1.0, tick: 1e-9 };

    /// A servo whose part is held: it turns until play and flex are taken up and friction holds the rest.
    fn settled(spec: &TwinSpec, target: f64) -> DriveTrain {
        let (servo, mut train) = (servo(spec), DriveTrain::at(0.0));
        for _ in 0..20_000 {
            train.step(&servo, &Around { target, ..HELD }, 1e-4);
        }
        train
    }

    #[test]
    fn within_the_play_nothing_is_pushed() {
        let spec = TwinSpec { friction: 0.0, spread: 0.0, ..TwinSpec::default() };
        let servo = servo(&spec);
        let mut train = DriveTrain { angle: 0.9 * servo.play, ..DriveTrain::at(0.0) };
        assert_eq!(train.step(&servo, &HELD, 1e-4), 0.0);
        train = DriveTrain { angle: servo.play + 0.01, ..DriveTrain::at(0.0) };
        let torque = train.step(&servo, &HELD, 1e-4);
        assert!((torque - 0.01 * servo.stiffness).abs() < 1e-9, "{torque}");
    }

    #[test]
    fn a_held_part_feels_the_gain_less_flex_and_friction() {
        let robot = Robot::load("lima").unwrap();
        let kp = robot.actuators.parameters[0].kp;
        let free = TwinSpec { friction: 0.0, spread: 0.0, ..TwinSpec::default() };
        let (own, target) = (servo(&free), 0.02);
        // In equilibrium T = kp (target - c T): the encoder sees the link's flex as movement.
        let expected = kp * target / (1.0 + kp * own.link_compliance);
        let train = settled(&free, target);
        assert!((train.torque / expected - 1.0).abs() < 1e-3, "{} {expected}", train.torque);
        assert!((train.current * own.motor.torque_constant / expected - 1.0).abs() < 1e-3);
        let rough = settled(&TwinSpec { friction: 1.0, ..free }, target);
        assert!(rough.torque < 0.9 * train.torque, "friction holds a part of it: {}", rough.torque);
    }
}
