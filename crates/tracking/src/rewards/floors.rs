//! Standard deviations that the thesis' reward divides errors by, and their lower bounds.

use lifelike_motion::FeatureLayout;

/// Smallest standard deviations for normalising features: a data set of calm clips has tiny ones, whose squares punish
/// every movement out of proportion. With `term_limit` and these floors the thesis' form learned on few clips.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Floors {
    /// Root height (m).
    pub height: f32,
    /// Root velocities (m/s and rad/s).
    pub velocity: f32,
    /// Joint positions (rad).
    pub joint_position: f32,
    /// Joint velocities (rad/s).
    pub joint_velocity: f32,
    /// End-effector positions (m).
    pub effectors: f32,
}

/// Key, unit and meaning of each floor.
pub(super) const SETTINGS: &[(&str, &str, &str)] = &[
    ("floors.height", "m", "thesis: smallest standard deviation of the root's height"),
    ("floors.velocity", "m/s, rad/s", "thesis: smallest standard deviation of the root's velocities"),
    ("floors.joint_position", "rad", "thesis: smallest standard deviation of a joint's position"),
    ("floors.joint_velocity", "rad/s", "thesis: smallest standard deviation of a joint's velocity"),
    ("floors.effectors", "m", "thesis: smallest standard deviation of an end effector's position"),
];

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
