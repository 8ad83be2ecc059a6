//! The kinematic state of thesis eq. 4.1: m_t = {h, θ, v, q, q̇, p}.
//!
//! One builder for clips and for simulated states alike, so a reward never compares two different definitions.

use std::ops::Range;

use lifelike_character::rotation::Turn;
use lifelike_character::{Character, Kinematics, Quat, Vec3};
use nalgebra::{RealField, UnitQuaternion, Vector3};

use crate::clip::MotionClip;
use crate::error::MotionError;

/// Layout of a feature vector: its parts by name.
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

    /// Returns the first of some frames that has other counts or a number that is not finite, the expected and the found.
    pub fn first_misfit(&self, frames: &[Frame]) -> Option<(usize, String, String)> {
        let expected = (self.joints.len(), self.joints.len(), self.end_effectors.len());
        let mut row = vec![0.0; self.size()];
        for (i, f) in frames.iter().enumerate() {
            let got = (f.joint_positions.len(), f.joint_velocities.len(), f.effectors_w.len());
            if got != expected {
                let say = |(q, v, p)| format!("{q} joint positions, {v} joint velocities, {p} end effectors");
                return Some((i, say(expected), say(got)));
            }
            f.write_features(&f.root_orientation, &mut row);
            if !row.iter().all(|x| x.is_finite()) {
                return Some((i, "finite numbers".into(), "NaN or infinity".into()));
            }
        }
        None
    }

    /// Returns the range of the joint positions q.
    pub fn joint_positions(&self) -> Range<usize> {
        13..13 + self.joints.len()
    }

    /// Returns the range of the joint velocities q̇.
    pub fn joint_velocities(&self) -> Range<usize> {
        let start = 13 + self.joints.len();
        start..start + self.joints.len()
    }

    /// Returns the range of the end-effector positions p relative to the root, in the heading frame (m).
    pub fn effectors(&self) -> Range<usize> {
        let start = 13 + 2 * self.joints.len();
        start..start + 3 * self.end_effectors.len()
    }

    /// Returns the length of a feature vector.
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
    /// Returns the length of this frame's feature vector: `FeatureLayout::size` of its layout.
    pub fn feature_size(&self) -> usize {
        13 + 2 * self.joint_positions.len() + 3 * self.effectors_w.len()
    }

    /// Writes eq. 4.1's features in the heading frame `frame_of` (thesis 4.2.1: the centre frame of a window; 4.2.2:
    /// the frame itself, W = 0).
    pub fn write_features(&self, frame_of: &Quat, out: &mut [f64]) {
        let frame = FrameRef {
            root_position: self.root_position,
            root_orientation: self.root_orientation,
            linear_velocity_w: self.linear_velocity_w,
            angular_velocity_w: self.angular_velocity_w,
            joint_positions: &self.joint_positions,
            joint_velocities: &self.joint_velocities,
        };
        frame.write_features(self.effectors_w.iter().copied(), Turn::heading(frame_of), out);
    }
}

/// A [`Frame`] whose joints lie elsewhere, in double (clips) or single precision (simulations).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameRef<'a, T: RealField> {
    /// Root position (m, world).
    pub root_position: Vector3<T>,
    /// Root orientation.
    pub root_orientation: UnitQuaternion<T>,
    /// Root linear velocity (m/s, world).
    pub linear_velocity_w: Vector3<T>,
    /// Root angular velocity (rad/s, world).
    pub angular_velocity_w: Vector3<T>,
    /// Joint positions (rad).
    pub joint_positions: &'a [T],
    /// Joint velocities (rad/s).
    pub joint_velocities: &'a [T],
}

impl<T: RealField + Copy> FrameRef<'_, T> {
    /// Writes eq. 4.1's features in a heading frame; `effectors_w` are the end effectors (m, world).
    #[inline]
    pub fn write_features(&self, effectors_w: impl Iterator<Item = Vector3<T>>, heading: Turn<T>, out: &mut [T]) {
        let to_heading = heading.inverse();
        let n = self.joint_positions.len();
        out[0] = self.root_position.z;
        out[1..7].copy_from_slice(&to_heading.apply_6d(&self.root_orientation));
        out[7..10].copy_from_slice(to_heading.apply(self.linear_velocity_w).as_slice());
        out[10..13].copy_from_slice(to_heading.apply(self.angular_velocity_w).as_slice());
        out[13..13 + n].copy_from_slice(self.joint_positions);
        out[13 + n..13 + 2 * n].copy_from_slice(self.joint_velocities);
        for (p, out) in effectors_w.zip(out[13 + 2 * n..].as_chunks_mut::<3>().0) {
            *out = to_heading.apply(p - self.root_position).into();
        }
    }
}

/// Returns every frame of a clip, with velocities: what windows, references and rewards are made from.
///
/// `effectors` are body indices and points in their frames (m). Joint columns come out in the CHARACTER's order,
/// whatever the clip's. Velocities are finite differences of the clip's own positions: the mean of the two neighbouring
/// differences inside (central difference), the one-sided difference at the ends; a cyclic clip has ends like any
/// other. Angular velocity is the quaternion logarithm of the turn from frame to frame, in the world frame, so
/// integrating velocities brings the positions back. A clip of one frame stands still.
///
/// # Errors
/// [`MotionError::Unfit`] for an inconsistent clip (see [`MotionClip::check`]) or a body that the character has not,
/// [`MotionError::Mismatch`] when clip and character name different joints.
pub fn frames_of(
    clip: &MotionClip,
    character: &Character,
    effectors: &[(usize, Vec3)],
) -> Result<Vec<Frame>, MotionError> {
    clip.check()?;
    let columns = clip.columns_for(character)?;
    if let Some((body, _)) = effectors.iter().find(|(body, _)| *body >= character.bodies.len()) {
        let message = format!("end effector on body {body}, but '{}' has {}", character.name, character.bodies.len());
        return Err(MotionError::Unfit { clip: clip.name.clone(), message });
    }
    let mut kinematics = Kinematics::new(character);
    let mut q = character.reference_position();
    let frames = (0..clip.len()).map(|i| {
        clip.write_position(character, &columns, i, &mut q);
        kinematics.update(character, &q);
        let row = clip.joints_at(i);
        Frame {
            root_position: clip.root_position[i],
            root_orientation: clip.root_orientation[i],
            linear_velocity_w: Vec3::zeros(),
            angular_velocity_w: Vec3::zeros(),
            joint_positions: columns.iter().map(|c| row[*c]).collect(),
            joint_velocities: vec![0.0; columns.len()],
            effectors_w: effectors.iter().map(|(body, point)| kinematics.point(*body, point)).collect(),
        }
    });
    let mut frames: Vec<Frame> = frames.collect();
    differentiate(&mut frames, clip.fps);
    Ok(frames)
}

/// Sets the velocities of frames that stand `1 / fps` s apart from their positions; see [`frames_of`].
pub fn differentiate(frames: &mut [Frame], fps: f64) {
    let n = frames.len();
    if n < 2 {
        return;
    }
    for i in 0..n {
        let (before, after) = (i.saturating_sub(1), (i + 1).min(n - 1));
        let rate = fps / (after - before) as f64;
        let (a, b) = (&frames[before], &frames[after]);
        let linear = (b.root_position - a.root_position) * rate;
        // Two half turns instead of one whole: unambiguous up to half a turn per frame, and still second order.
        let here = frames[i].root_orientation;
        let turn =
            (here * a.root_orientation.inverse()).scaled_axis() + (b.root_orientation * here.inverse()).scaled_axis();
        let joints = b.joint_positions.iter().zip(&a.joint_positions).map(|(b, a)| (b - a) * rate).collect();
        let frame = &mut frames[i];
        frame.linear_velocity_w = linear;
        frame.angular_velocity_w = turn * rate;
        frame.joint_velocities = joints;
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::clip::Provenance;
    use crate::fixtures::swing;
    use lifelike_character::Quat;

    fn clip(frames: usize, pose: impl Fn(f64) -> (Vec3, Quat, [f64; 2])) -> MotionClip {
        let mut clip = MotionClip {
            name: "test".into(),
            fps: 50.0,
            joint_names: vec!["slide".into(), "hinge".into()],
            root_position: vec![],
            root_orientation: vec![],
            joints: vec![],
            contacts: None,
            cyclic: false,
            provenance: Provenance::default(),
        };
        for i in 0..frames {
            let (p, r, j) = pose(i as f64 / clip.fps);
            clip.root_position.push(p);
            clip.root_orientation.push(r);
            clip.joints.extend(j);
        }
        clip
    }

    #[test]
    fn velocities_are_those_of_the_motion_and_in_the_world_frame() {
        // Uniform motion: differences are exact. The root turns about the WORLD's vertical while it is tilted, so a
        // body-frame angular velocity would not point along z.
        let tilt = Quat::from_euler_angles(0.7, -0.4, 0.0);
        let clip = clip(20, |t| {
            let turn = Quat::from_euler_angles(0.0, 0.0, 3.0 * t);
            (Vec3::new(2.0 * t, -t, 1.0), turn * tilt, [0.1 * t, -5.0 * t])
        });
        let character = swing();
        let frames = frames_of(&clip, &character, &[(2, Vec3::new(0.0, 0.0, -0.5))]).unwrap();
        for frame in &frames {
            assert!((frame.linear_velocity_w - Vec3::new(2.0, -1.0, 0.0)).norm() < 1e-9);
            assert!(
                (frame.angular_velocity_w - Vec3::new(0.0, 0.0, 3.0)).norm() < 1e-9,
                "{:?}",
                frame.angular_velocity_w
            );
            // The clip's columns are (slide, hinge); the character's joints are (hinge, slide).
            assert!((frame.joint_velocities[0] + 5.0).abs() < 1e-9);
            assert!((frame.joint_velocities[1] - 0.1).abs() < 1e-9);
        }
    }

    #[test]
    fn central_differences_inside_one_sided_at_the_ends() {
        let clip = clip(5, |t| (Vec3::new(t * t, 0.0, 0.0), Quat::identity(), [0.0, t * t]));
        let frames = frames_of(&clip, &swing(), &[]).unwrap();
        // d(t²)/dt at 0.02 k is 0.04 k by central differences; one-sided at the ends: 0.02 and 0.14.
        for (frame, expected) in frames.iter().zip([0.02, 0.04, 0.08, 0.12, 0.14]) {
            assert!((frame.linear_velocity_w.x - expected).abs() < 1e-12);
            assert!((frame.joint_velocities[0] - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn effectors_follow_root_and_joints() {
        // The arm hangs from (0, 0, 0.1) in the root's frame and turns about y: at 90 degrees its tip, 0.5 m below the
        // joint, points to -x. The slide then moves along the arm's z axis.
        let half = std::f64::consts::FRAC_PI_2;
        let clip = clip(2, |_| (Vec3::new(1.0, 2.0, 3.0), Quat::from_euler_angles(0.0, 0.0, half), [0.2, half]));
        let frames = frames_of(&clip, &swing(), &[(2, Vec3::new(0.0, 0.0, -0.5))]).unwrap();
        // In the root's frame: (-0.5 + 0.2, 0, 0.1); the root faces +y.
        let expected = Vec3::new(1.0, 2.0 - 0.3, 3.1);
        assert!((frames[0].effectors_w[0] - expected).norm() < 1e-12, "{:?}", frames[0].effectors_w[0]);
    }

    #[test]
    fn single_precision_gives_the_features_within_its_rounding() {
        // Of roots up to 10 m away, in any orientation that is not close to looking straight up.
        for i in 0..200 {
            let t = f64::from(i);
            let vector = |a: f64| Vec3::new((a * t).sin(), (a * t + 1.0).sin(), (a * t + 2.0).sin());
            let frame = Frame {
                root_position: 10.0 * vector(0.7),
                root_orientation: Quat::from_euler_angles(3.0 * t.sin(), 1.3 * (0.7 * t).cos(), 1.3 * t),
                linear_velocity_w: vector(1.1),
                angular_velocity_w: vector(1.7),
                joint_positions: vec![0.3 * t.sin()],
                joint_velocities: vec![3.0 * t.sin()],
                effectors_w: vec![10.0 * vector(0.7) + vector(2.3)],
            };
            let mut exact = vec![0.0; frame.feature_size()];
            frame.write_features(&frame.root_orientation, &mut exact);
            let single = |x: &[f64]| x.iter().map(|x| *x as f32).collect::<Vec<_>>();
            let (positions, velocities) = (single(&frame.joint_positions), single(&frame.joint_velocities));
            let narrow = FrameRef::<f32> {
                root_position: frame.root_position.cast(),
                root_orientation: frame.root_orientation.cast(),
                linear_velocity_w: frame.linear_velocity_w.cast(),
                angular_velocity_w: frame.angular_velocity_w.cast(),
                joint_positions: &positions,
                joint_velocities: &velocities,
            };
            let mut out = vec![0.0_f32; exact.len()];
            let effectors = frame.effectors_w.iter().map(|p| p.cast());
            narrow.write_features(effectors, Turn::heading(&narrow.root_orientation), &mut out);
            for (got, exact) in out.iter().zip(&exact) {
                assert!((f64::from(*got) - exact).abs() < 5e-6, "{got} {exact}");
            }
        }
    }

    #[test]
    fn wrong_names_and_bodies_are_told() {
        let mut clip = clip(2, |_| (Vec3::zeros(), Quat::identity(), [0.0, 0.0]));
        assert!(matches!(frames_of(&clip, &swing(), &[(9, Vec3::zeros())]), Err(MotionError::Unfit { .. })));
        clip.joint_names[0] = "elbow".into();
        let message = frames_of(&clip, &swing(), &[]).unwrap_err().to_string();
        assert!(message.contains("elbow") && message.contains("slide"), "{message}");
    }
}
