//! Settings of the sensor model: noise and delays.

use lifelike_train::limits::{range, whole};

use crate::TrackerError;

/// Standard deviations of the noise on measurements, and the greatest delays. All zero by default.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensorSpec {
    /// Noise on the six numbers of the root's orientation: about the angle (rad).
    pub orientation_noise: f32,
    /// Noise on the root's linear velocity (m/s).
    pub linear_velocity_noise: f32,
    /// Noise on the root's angular velocity (rad/s).
    pub angular_velocity_noise: f32,
    /// Noise on joint positions (rad).
    pub joint_position_noise: f32,
    /// Noise on joint velocities (rad/s).
    pub joint_velocity_noise: f32,
    /// Greatest delay of measurements (policy steps); each episode draws its own.
    pub observation_delay: u32,
    /// Greatest delay of joint targets on their way to the motors (policy steps); likewise.
    pub action_delay: u32,
}

impl SensorSpec {
    /// Checks that every value is in its range.
    ///
    /// # Errors
    /// [`TrackerError::Plan`] with the key, the range and the value.
    pub fn check(&self) -> Result<(), TrackerError> {
        for (key, noise) in [
            ("sensors.orientation_noise", self.orientation_noise),
            ("sensors.linear_velocity_noise", self.linear_velocity_noise),
            ("sensors.angular_velocity_noise", self.angular_velocity_noise),
            ("sensors.joint_position_noise", self.joint_position_noise),
            ("sensors.joint_velocity_noise", self.joint_velocity_noise),
        ] {
            range(key, noise.into(), 0.0, 10.0)?;
        }
        whole("sensors.observation_delay", self.observation_delay.into(), 0, 50)?;
        Ok(whole("sensors.action_delay", self.action_delay.into(), 0, 50)?)
    }
}
