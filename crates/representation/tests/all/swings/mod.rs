//! Synthetic motion for the promises of priors.

use lifelike_character::{Quat, Vec3};
use lifelike_motion::{FeatureLayout, Frame};
use lifelike_representation::PriorClip;

const JOINTS: usize = 4;

/// Four joints and two feet.
pub fn layout() -> FeatureLayout {
    FeatureLayout {
        joints: (0..JOINTS).map(|i| format!("joint_{i}")).collect(),
        end_effectors: vec!["left_foot".into(), "right_foot".into()],
    }
}

/// A clip of a swinging figure; consistent velocities.
pub fn clip(index: usize, frames: usize) -> PriorClip {
    let rate = 2.0 + 0.37 * index as f64;
    let frame = |i: usize| {
        let t = i as f64 / 50.0;
        let turn = Quat::from_euler_angles(0.05 * (rate * t).sin(), 0.1, 0.3 * t + index as f64);
        let root = Vec3::new(t, 0.0, 0.8 + 0.03 * (2.0 * rate * t).sin());
        let phase = |j: usize| rate * t + j as f64;
        let foot = |side: f64| root + turn * Vec3::new(0.3 * (rate * t).sin() * side, 0.1 * side, -0.75);
        Frame {
            root_position: root,
            root_orientation: turn,
            linear_velocity_w: turn * Vec3::new(1.0, 0.0, 0.06 * rate * (2.0 * rate * t).cos()),
            angular_velocity_w: Vec3::new(0.05 * rate * (rate * t).cos(), 0.0, 0.3),
            joint_positions: (0..JOINTS).map(|j| 0.5 * phase(j).sin()).collect(),
            joint_velocities: (0..JOINTS).map(|j| 0.5 * rate * phase(j).cos()).collect(),
            effectors_w: vec![foot(1.0), foot(-1.0)],
        }
    };
    PriorClip { name: format!("swing_{index}"), frames: (0..frames).map(frame).collect() }
}

/// Eight of them, 120 frames each.
pub fn clips() -> Vec<PriorClip> {
    (0..8).map(|i| clip(i, 120)).collect()
}
