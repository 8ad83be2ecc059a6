//! Tracking errors: distances between a simulated state and its reference, which terminations look at.

use lifelike_motion::FeatureLayout;
use lifelike_robot::reference::Offset;

/// Distances between a simulated state and its reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackingError {
    /// Root height (m, absolute).
    pub height: f32,
    /// Angle between the two directions of gravity in the root's frame (rad).
    pub tilt: f32,
    /// Largest end-effector distance (m; heading frame, relative to the root).
    pub effector: f32,
    /// Distance on the ground (m).
    pub path: f32,
    /// Heading (rad, absolute).
    pub heading: f32,
    /// Mean over joints of the absolute position error (rad).
    pub joints: f32,
}

impl TrackingError {
    /// Returns the errors by the features of both (each in its own heading frame) and by where the robot is against the
    /// anchored reference.
    #[inline]
    pub fn between(layout: &FeatureLayout, simulated: &[f32], reference: &[f32], offset: &Offset) -> Self {
        let effectors = layout.effectors();
        let effector = simulated[effectors.clone()]
            .as_chunks::<3>()
            .0
            .iter()
            .zip(reference[effectors].as_chunks::<3>().0)
            .map(|(a, b)| (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]))
            .fold(0.0, f32::max)
            .sqrt();
        let joints = layout.joint_positions();
        let apart = simulated[joints.clone()].iter().zip(&reference[joints.clone()]).map(|(a, b)| (a - b).abs());
        let (a, b) = (gravity(simulated), gravity(reference));
        let cosine = a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>();
        Self {
            height: (simulated[FeatureLayout::HEIGHT] - reference[FeatureLayout::HEIGHT]).abs(),
            tilt: cosine.clamp(-1.0, 1.0).acos(),
            effector,
            path: offset.distance(),
            heading: offset.heading.abs(),
            joints: apart.sum::<f32>() / joints.len().max(1) as f32,
        }
    }
}

/// Returns the direction of up in the root's frame: the third row of the rotation, of which the features hold two columns.
fn gravity(features: &[f32]) -> [f32; 3] {
    let d = &features[FeatureLayout::ORIENTATION];
    [d[2], d[5], d[0] * d[4] - d[1] * d[3]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use lifelike_character::{Quat, Vec3};
    use lifelike_motion::Frame;

    fn layout() -> FeatureLayout {
        FeatureLayout { joints: vec!["hip".into(), "knee".into()], end_effectors: vec!["a".into(), "b".into()] }
    }

    fn features(q: Quat, height: f64, b: [f64; 3], joints: [f64; 2]) -> Vec<f32> {
        let frame = Frame {
            root_position: Vec3::new(0.0, 0.0, height),
            root_orientation: q,
            linear_velocity_w: Vec3::zeros(),
            angular_velocity_w: Vec3::zeros(),
            joint_positions: joints.to_vec(),
            joint_velocities: vec![0.0; 2],
            effectors_w: vec![Vec3::zeros(), Vec3::new(b[0], b[1], b[2] + height)],
        };
        let mut out = vec![0.0; layout().size()];
        frame.write_features(&q, &mut out);
        out.iter().map(|x| *x as f32).collect()
    }

    #[test]
    fn tracking_errors_by_hand() {
        let simulated = features(Quat::from_euler_angles(0.5, 0.0, 2.0), 1.0, [0.0, 0.0, 0.0], [0.1, -0.2]);
        let reference = features(Quat::from_euler_angles(0.0, 0.0, -1.0), 1.0, [0.0, 0.0, 0.3], [0.0, 0.2]);
        let offset = Offset { place: [0.0; 2], ground: [0.0, -0.7], heading: -0.2 };
        let e = TrackingError::between(&layout(), &simulated, &reference, &offset);
        assert!((e.tilt - 0.5).abs() < 1e-5, "turning about the vertical does not tilt: {}", e.tilt);
        assert!((e.effector - 0.3).abs() < 1e-6, "the largest of the two: {}", e.effector);
        assert!((e.joints - 0.25).abs() < 1e-6, "0.1 and 0.4 rad: {}", e.joints);
        assert_eq!((e.height, e.path, e.heading), (0.0, 0.7, 0.2));
    }
}
