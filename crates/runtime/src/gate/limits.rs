//! Limits of one robot, from its description and a configuration.

use lifelike_robot::{ActionSpec, Robot};

use crate::{FromInput, RuntimeError};

/// Limits that the user may set (TOML, table `[limits]`). Shares are of the robot's own limits.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LimitSettings {
    /// Share of the largest torque.
    pub torque_share: f64,
    /// Share of the range that targets may use, about its middle; 1: the range and the margin of training.
    pub range_share: f64,
    /// Largest tilt of the root against the reference (rad).
    pub tilt_max: f64,
    /// Largest distance of a joint from the reference (rad).
    pub tracking_max: f64,
    /// Longest time beyond `tracking_max` (s).
    pub tracking_time: f64,
    /// Share of the largest velocity at which the gate trips.
    pub velocity_share: f64,
    /// Time without a usable packet after which the gate trips (s).
    pub lost_time: f64,
    /// Largest delay of packets beyond the fastest (s).
    pub delay_max: f64,
    /// Longest time between two ticks (s).
    pub overrun_time: f64,
    /// Time for which an encoder may repeat itself while its joint must move (s).
    pub freeze_time: f64,
    /// Time constant of the motors' heat (s).
    pub thermal_time: f64,
    /// Temperature at which torque begins to be reduced (degrees Celsius).
    pub temperature_derate: f64,
    /// Temperature at which the gate trips (degrees Celsius).
    pub temperature_max: f64,
    /// Lowest voltage of the supply (V); 0: not checked.
    pub battery_min: f64,
}

impl Default for LimitSettings {
    fn default() -> Self {
        Self {
            torque_share: 1.0,
            range_share: 1.0,
            tilt_max: 1.0,
            tracking_max: 1.2,
            tracking_time: 0.5,
            velocity_share: 2.0,
            lost_time: 0.05,
            delay_max: 0.05,
            overrun_time: 0.1,
            freeze_time: 0.1,
            thermal_time: 60.0,
            temperature_derate: 70.0,
            temperature_max: 90.0,
            battery_min: 0.0,
        }
    }
}

impl LimitSettings {
    /// Checks the numbers.
    ///
    /// # Errors
    /// The first that is out of range.
    pub fn check(&self) -> Result<(), RuntimeError> {
        let positive = [
            ("limits.tilt_max", self.tilt_max),
            ("limits.tracking_max", self.tracking_max),
            ("limits.tracking_time", self.tracking_time),
            ("limits.velocity_share", self.velocity_share),
            ("limits.lost_time", self.lost_time),
            ("limits.delay_max", self.delay_max),
            ("limits.overrun_time", self.overrun_time),
            ("limits.freeze_time", self.freeze_time),
            ("limits.thermal_time", self.thermal_time),
            ("limits.temperature_derate", self.temperature_derate),
        ];
        for (key, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                return Err(RuntimeError::mismatch(key, "a number above 0", value));
            }
        }
        for (key, value) in [("limits.torque_share", self.torque_share), ("limits.range_share", self.range_share)] {
            if !(value > 0.0 && value <= 1.0) {
                return Err(RuntimeError::mismatch(key, "a share above 0 and at most 1", value));
            }
        }
        if self.temperature_max.is_nan() || self.temperature_max <= self.temperature_derate {
            let expected = format!("more than limits.temperature_derate ({})", self.temperature_derate);
            return Err(RuntimeError::mismatch("limits.temperature_max", &expected, self.temperature_max));
        }
        if !(self.battery_min.is_finite() && self.battery_min >= 0.0) {
            return Err(RuntimeError::mismatch("limits.battery_min", "a number of at least 0", self.battery_min));
        }
        Ok(())
    }
}

/// Limits of one joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointLimits {
    /// Least and greatest target (rad).
    pub position: (f32, f32),
    /// Largest speed of the target (rad/s).
    pub rate: f32,
    /// Largest acceleration of the target (rad/s²).
    pub acceleration: f32,
    /// Largest torque (N m).
    pub torque: f32,
    /// Torque that the motor holds for any time (N m).
    pub torque_continuous: f32,
    /// Proportional gain (N m/rad).
    pub kp: f32,
    /// Derivative gain (N m s/rad).
    pub kd: f32,
    /// Largest measured velocity (rad/s).
    pub velocity: f32,
}

/// Limits of a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// Limits of each joint, `[J]`.
    pub joints: Vec<JointLimits>,
    /// Limits of the whole.
    pub settings: LimitSettings,
}

impl Limits {
    /// Returns the limits of a robot.
    ///
    /// A target that moves by twice the largest torque over kp reverses that torque. It may do so within a quarter of a
    /// policy step, and it reaches that speed within an eighth of one. Slower targets delay policies whose motors are often
    /// at their largest torque.
    ///
    /// # Errors
    /// A setting is out of range.
    pub fn of(robot: &Robot, settings: LimitSettings) -> Result<Self, RuntimeError> {
        settings.check()?;
        let parameters = robot.actuators.parameters.iter().zip(robot.continuous_torques());
        let joints = robot.character.scalar_joints().zip(parameters).map(|(joint, (actuator, continuous))| {
            let torque = settings.torque_share * actuator.torque_max;
            let rate = 8.0 * actuator.torque_max / actuator.kp.max(1e-6) * robot.control_hz;
            let position = joint.range.map_or((f32::MIN, f32::MAX), |(low, high)| {
                let margin = match joint.kind {
                    lifelike_character::JointKind::Slide => 0.1 * (high - low),
                    _ => ActionSpec::TARGET_MARGIN,
                };
                let (middle, half) = (0.5 * (low + high), 0.5 * (high - low) + margin);
                let half = if settings.range_share < 1.0 { settings.range_share * (half - margin) } else { half };
                ((middle - half) as f32, (middle + half) as f32)
            });
            JointLimits {
                position,
                rate: rate as f32,
                acceleration: (8.0 * rate * robot.control_hz) as f32,
                torque: torque as f32,
                torque_continuous: continuous.min(torque) as f32,
                kp: actuator.kp as f32,
                kd: actuator.kd as f32,
                velocity: (settings.velocity_share * actuator.velocity_max) as f32,
            }
        });
        Ok(Self { joints: joints.collect(), settings })
    }
}
