//! The kinematic state of thesis eq. 4.1: m_t = {h, θ, v, q, q̇, p}.
//!
//! One builder for clips and for simulated states alike, so a reward never compares two different definitions.

use std::ops::Range;

use lifelike_character::rotation::{heading, to_6d};
use lifelike_character::{Quat, Vec3};

/// Where each part of a feature vector lies, by name.
///
/// # Shapes
/// `size = 1 + 6 + 6 + J + J + 3 E` for `J` joints and `E` end effectors.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FeatureLayout {
    /// Joint names, in column order.
    pub joints: Vec<String>,
    /// End-effector names (hands and feet), in column order.
    pub end_effectors: Vec<String>,
}

impl FeatureLayout {
    /// Root height h (m).
    pub const HEIGHT: usize = 0;
    /// Root orientation θ as 6D.
    pub const ORIENTATION: Range<usize> = 1..7;
    /// Root velocity v: linear (m/s), then angular (rad/s), both in the heading frame.
    pub const VELOCITY: Range<usize> = 7..13;

    /// Joint positions q.
    pub fn joint_positions(&self) -> Range<usize> {
        13..13 + self.joints.len()
    }

    /// Joint velocities q̇.
    pub fn joint_velocities(&self) -> Range<usize> {
        let start = 13 + self.joints.len();
        start..start + self.joints.len()
    }

    /// End-effector positions p relative to the root, in the heading frame (m).
    pub fn effectors(&self) -> Range<usize> {
        let start = 13 + 2 * self.joints.len();
        start..start + 3 * self.end_effectors.len()
    }

    /// Length of a feature vector.
    pub fn size(&self) -> usize {
        13 + 2 * self.joints.len() + 3 * self.end_effectors.len()
    }
}

/// One instant of a character's motion in the world frame: what features are computed from.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Root position (m, world).
    pub root_position: Vec3,
    /// Root orientation.
    pub root_orientation: Quat,
    /// Root linear velocity (m/s, world).
    pub linear_velocity_w: Vec3,
    /// Root angular velocity (rad/s, world).
    pub angular_velocity_w: Vec3,
    /// Joint positions (rad).
    pub joint_positions: Vec<f64>,
    /// Joint velocities (rad/s).
    pub joint_velocities: Vec<f64>,
    /// End-effector positions (m, world).
    pub effectors_w: Vec<Vec3>,
}

impl Frame {
    /// Writes eq. 4.1's features in the heading frame `frame_of` (thesis 4.2.1: the centre frame of a window; 4.2.2: the
    /// frame itself, W = 0).
    pub fn write_features(&self, frame_of: &Quat, out: &mut [f64]) {
        let to_heading = heading(frame_of).inverse();
        let n = self.joint_positions.len();
        out[0] = self.root_position.z;
        out[1..7].copy_from_slice(&to_6d(&(to_heading * self.root_orientation)));
        out[7..10].copy_from_slice((to_heading * self.linear_velocity_w).as_slice());
        out[10..13].copy_from_slice((to_heading * self.angular_velocity_w).as_slice());
        out[13..13 + n].copy_from_slice(&self.joint_positions);
        out[13 + n..13 + 2 * n].copy_from_slice(&self.joint_velocities);
        for (i, p) in self.effectors_w.iter().enumerate() {
            let at = 13 + 2 * n + 3 * i;
            out[at..at + 3].copy_from_slice((to_heading * (p - self.root_position)).as_slice());
        }
    }
}
