//! Standard deviations that the thesis' reward divides errors by, and their lower bounds.

use lifelike_motion::FeatureLayout;

/// Smallest standard deviations for normalising features: a data set of calm clips has tiny ones, whose squares punish
/// every movement out of proportion. With `term_limit` and these floors the thesis' form learned on few clips.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Floors {
    /// Smallest standard deviation of the root's height (m).
    #[schemars(extend("unit" = "m"), range(min = 0.0, max = 1e6))]
    pub height: f32,
    /// Smallest standard deviation of the root's velocities (m/s, rad/s).
    #[schemars(extend("unit" = "m/s, rad/s"), range(min = 0.0, max = 1e6))]
    pub velocity: f32,
    /// Smallest standard deviation of a joint's position (rad).
    #[schemars(extend("unit" = "rad"), range(min = 0.0, max = 1e6))]
    pub joint_position: f32,
    /// Smallest standard deviation of a joint's velocity (rad/s).
    #[schemars(extend("unit" = "rad/s"), range(min = 0.0, max = 1e6))]
    pub joint_velocity: f32,
    /// Smallest standard deviation of an end effector's position (m).
    #[schemars(extend("unit" = "m"), range(min = 0.0, max = 1e6))]
    pub effectors: f32,
}

impl Floors {
    /// Returns the divisor of every feature: the data's standard deviation, not below the floor; 1 for the orientation,
    /// which the thesis leaves as it is.
    pub fn apply(&self, layout: &FeatureLayout, deviation: &[f32]) -> Vec<f32> {
        let mut out = deviation.to_vec();
        out[FeatureLayout::HEIGHT] = out[FeatureLayout::HEIGHT].max(self.height);
        out[FeatureLayout::ORIENTATION].fill(1.0);
        let parts = [
            (FeatureLayout::VELOCITY, self.velocity),
            (layout.joint_positions(), self.joint_position),
            (layout.joint_velocities(), self.joint_velocity),
            (layout.effectors(), self.effectors),
        ];
        for (range, floor) in parts {
            out[range].iter_mut().for_each(|s| *s = s.max(floor));
        }
        out
    }
}
