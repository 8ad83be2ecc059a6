//! How good a robot's senses are, and how late.

use crate::TrackerError;
use lifelike_train::limits::{range, whole};

/// Standard deviations of the noise on what is measured, and the greatest delays. Nothing by default.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SenseSpec {
    /// On the six numbers of the root's orientation: about the angle (rad).
    pub orientation_noise: f32,
    /// On the root's linear velocity (m/s).
    pub linear_velocity_noise: f32,
    /// On the root's angular velocity (rad/s).
    pub angular_velocity_noise: f32,
    /// On joint positions (rad).
    pub joint_position_noise: f32,
    /// On joint velocities (rad/s).
    pub joint_velocity_noise: f32,
    /// What is measured is seen late by up to so many policy steps; each episode draws its own delay.
    pub observation_delay: u32,
    /// Joint targets reach the motors late by up to so many policy steps; likewise.
    pub action_delay: u32,
}

impl SenseSpec {
    /// Whether every value is in its range.
    ///
    /// # Errors
    /// [`TrackerError::Plan`] with the key, the range and the value.
    pub fn check(&self) -> Result<(), TrackerError> {
        for (key, noise) in [
            ("senses.orientation_noise", self.orientation_noise),
            ("senses.linear_velocity_noise", self.linear_velocity_noise),
            ("senses.angular_velocity_noise", self.angular_velocity_noise),
            ("senses.joint_position_noise", self.joint_position_noise),
            ("senses.joint_velocity_noise", self.joint_velocity_noise),
        ] {
            range(key, noise.into(), 0.0, 10.0)?;
        }
        whole("senses.observation_delay", self.observation_delay.into(), 0, 50)?;
        Ok(whole("senses.action_delay", self.action_delay.into(), 0, 50)?)
    }
}
