//! Settings of the sensor model: noise and delays.

/// Standard deviations of the noise on measurements, and the greatest delays. All zero by default.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SensorSpec {
    /// Noise on the root's orientation, standard deviation (rad).
    #[schemars(extend("unit" = "rad"), range(min = 0.0, max = 10.0))]
    pub orientation_noise: f32,
    /// Noise on the root's linear velocity, standard deviation (m/s).
    #[schemars(extend("unit" = "m/s"), range(min = 0.0, max = 10.0))]
    pub linear_velocity_noise: f32,
    /// Noise on the root's angular velocity, standard deviation (rad/s).
    #[schemars(extend("unit" = "rad/s"), range(min = 0.0, max = 10.0))]
    pub angular_velocity_noise: f32,
    /// Noise on joint positions, standard deviation (rad).
    #[schemars(extend("unit" = "rad"), range(min = 0.0, max = 10.0))]
    pub joint_position_noise: f32,
    /// Noise on joint velocities, standard deviation (rad/s).
    #[schemars(extend("unit" = "rad/s"), range(min = 0.0, max = 10.0))]
    pub joint_velocity_noise: f32,
    /// Largest delay of measurements; each episode draws its own (policy steps).
    #[schemars(extend("unit" = "policy steps"), range(min = 0, max = 50))]
    pub observation_delay: u32,
    /// Largest delay of joint targets; each episode draws its own (policy steps).
    #[schemars(extend("unit" = "policy steps"), range(min = 0, max = 50))]
    pub action_delay: u32,
}
