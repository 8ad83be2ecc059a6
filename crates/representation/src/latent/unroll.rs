//! From features back to a motion: the inverse of eq. 4.1, up to where the motion begins and which way it faces there.

use lifelike_character::rotation::{from_6d, heading, heading_angle};
use lifelike_character::{Character, Quat, Vec3};
use lifelike_motion::{FeatureLayout, MotionClip, Provenance};

use crate::{FromInput, RepresentationError};

/// A motion made of features.
#[derive(Debug, Clone, PartialEq)]
pub struct Unrolled {
    /// The motion; it begins at the origin and faces forward.
    pub clip: MotionClip,
    /// Share of joint values that were beyond their joint's range and are at its end now.
    pub clamped: f64,
    /// Furthest that one was beyond it (rad).
    pub excess: f64,
}

/// Returns the motion whose frames have these features, each in its own heading frame.
///
/// Joints, height and tilt are as the features say, joints within their ranges. The path on the ground and the heading are
/// integrated from the features' velocities (trapezoids). `pace` is how fast each frame is played against what its
/// velocities say: 1 for features of frames that stand `1 / fps` s apart.
///
/// # Shapes
/// `features: [T, F]` in SI units, `pace: [T]`.
///
/// # Errors
/// Numbers of rows that differ, an orientation without direction, or joints that are not the character's.
pub fn unroll(
    features: &[f64],
    pace: &[f64],
    layout: &FeatureLayout,
    fps: f64,
    character: &Character,
) -> Result<Unrolled, RepresentationError> {
    let size = layout.size();
    if pace.len().checked_mul(size) != Some(features.len()) || pace.is_empty() {
        let expected = format!("{} rows of {size}, at least one", pace.len());
        let got = format!("{} numbers", features.len());
        return Err(RepresentationError::mismatch("features of a motion", expected, got));
    }
    let mut clip = MotionClip {
        name: "unrolled".into(),
        fps,
        joint_names: layout.joints.clone(),
        root_position: Vec::with_capacity(pace.len()),
        root_orientation: Vec::with_capacity(pace.len()),
        joints: Vec::with_capacity(pace.len() * layout.joints.len()),
        contacts: None,
        cyclic: false,
        provenance: Provenance { character: character.name.clone(), ..Provenance::default() },
    };
    clip.joints = features.chunks_exact(size).flat_map(|row| &row[layout.joint_positions()]).copied().collect();
    let (clamped, excess) = clamp(&mut clip, character)?;
    walk(&mut clip, features, pace, size)?;
    clip.check()?;
    Ok(Unrolled { clip, clamped, excess })
}

/// Puts the root where the features lead it.
fn walk(clip: &mut MotionClip, features: &[f64], pace: &[f64], size: usize) -> Result<(), RepresentationError> {
    let three = |row: &[f64], at: usize| Vec3::new(row[at], row[at + 1], row[at + 2]);
    let velocity = FeatureLayout::VELOCITY.start;
    let dt = 1.0 / clip.fps;
    let mut place = Vec3::zeros();
    let mut yaw = 0.0;
    // Tilt and velocities of the frame before, in its heading frame.
    let mut before: Option<(Quat, Vec3, Vec3)> = None;
    for (i, (row, pace)) in features.chunks_exact(size).zip(pace).enumerate() {
        let six = <[f64; 6]>::try_from(&row[FeatureLayout::ORIENTATION]).ok();
        let turned = six.and_then(from_6d).ok_or_else(|| {
            RepresentationError::mismatch(
                format!("orientation in frame {i} of a motion"),
                "two columns of a rotation",
                format!("{six:?}"),
            )
        })?;
        // What a network decodes does not face exactly forward in its own heading frame.
        let tilt = heading(&turned).inverse() * turned;
        let (linear, angular) = (three(row, velocity) * *pace, three(row, velocity + 3) * *pace);
        if let Some((tilt_before, linear_before, angular_before)) = before {
            let at = |yaw: f64| Quat::from_axis_angle(&Vec3::z_axis(), yaw);
            let turn = Quat::from_scaled_axis((angular_before + angular) * (0.5 * dt));
            // By way of the whole rotation: a turn about a tilted axis changes the heading by another angle than its z.
            let next = yaw + heading_angle(&(turn * tilt_before));
            place += (at(yaw) * linear_before + at(next) * linear) * (0.5 * dt);
            yaw = next;
        }
        before = Some((tilt, linear, angular));
        clip.root_position.push(Vec3::new(place.x, place.y, row[FeatureLayout::HEIGHT]));
        let orientation = Quat::from_axis_angle(&Vec3::z_axis(), yaw) * tilt;
        let flipped = clip.root_orientation.last().is_some_and(|last| last.coords.dot(&orientation.coords) < 0.0);
        clip.root_orientation.push(if flipped { Quat::new_unchecked(-orientation.into_inner()) } else { orientation });
    }
    Ok(())
}

/// Brings every joint into its range; says how many values were outside, and how far.
fn clamp(clip: &mut MotionClip, character: &Character) -> Result<(f64, f64), RepresentationError> {
    let mut ranges = Vec::with_capacity(clip.joint_names.len());
    for name in &clip.joint_names {
        let joint = character.scalar_joints().find(|j| j.name == *name);
        ranges.push(joint.map(|j| j.range).ok_or_else(|| {
            RepresentationError::mismatch(
                format!("joint '{name}' of a motion"),
                format!("a joint of '{}'", character.name),
                "none of this name",
            )
        })?);
    }
    let (mut beyond, mut excess) = (0_usize, 0.0_f64);
    for row in clip.joints.chunks_exact_mut(ranges.len().max(1)) {
        for (value, range) in row.iter_mut().zip(&ranges) {
            let Some((low, high)) = *range else { continue };
            let inside = value.max(low).min(high);
            if inside != *value {
                beyond += 1;
                excess = excess.max((inside - *value).abs());
                *value = inside;
            }
        }
    }
    Ok((beyond as f64 / clip.joints.len().max(1) as f64, excess))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use lifelike_character::rotation::to_6d;
    use lifelike_motion::features::frames_of;
    use lifelike_robot::Robot;

    /// Returns a walk in a curve, pitching and rolling, knees bent by `bend`.
    fn curve(robot: &Robot, bend: f64) -> MotionClip {
        let frames = 200;
        let pose = |i: usize| {
            let t = i as f64 / 50.0;
            let yaw = 0.8 * t + 0.3 * (2.0 * t).sin();
            let place = Vec3::new(1.2 * (0.8 * t).sin(), 1.2 * (1.0 - (0.8 * t).cos()), 0.5 + 0.02 * (6.0 * t).sin());
            (place, Quat::from_euler_angles(0.1 * (3.0 * t).sin(), 0.2 + 0.1 * (4.0 * t).cos(), yaw))
        };
        MotionClip {
            name: "curve".into(),
            fps: 50.0,
            joint_names: robot.layout.joints.clone(),
            root_position: (0..frames).map(|i| pose(i).0).collect(),
            root_orientation: (0..frames).map(|i| pose(i).1).collect(),
            joints: robot.default_pose.iter().map(|q| q + bend).collect::<Vec<_>>().repeat(frames),
            contacts: None,
            cyclic: false,
            provenance: Provenance::default(),
        }
    }

    fn features(robot: &Robot, clip: &MotionClip) -> Vec<f64> {
        let size = robot.layout.size();
        let mut out = vec![0.0; size * clip.len()];
        let frames = frames_of(clip, &robot.character, &robot.effectors).unwrap();
        for (frame, row) in frames.iter().zip(out.chunks_exact_mut(size)) {
            frame.write_features(&frame.root_orientation, row);
        }
        out
    }

    #[test]
    fn a_motion_comes_back_from_its_features() {
        let robot = Robot::load("lima").unwrap();
        let clip = curve(&robot, 0.0);
        let back = unroll(&features(&robot, &clip), &[1.0; 200], &robot.layout, 50.0, &robot.character).unwrap();
        assert_eq!((back.clamped, &back.clip.joints), (0.0, &clip.joints));
        // The same up to where it began and faced.
        let (place, facing) = (clip.root_position[0], heading(&clip.root_orientation[0]));
        for i in 0..clip.len() {
            let there = facing * back.clip.root_position[i] + Vec3::new(place.x, place.y, 0.0);
            // Second-order differences and trapezoids: the step's square times the third derivative, over 4 s. With
            // angles like 0.1 sin(4 t) that is 0.02² x 6 x 4 s x a third: about 3 mm and 3 mrad.
            let apart = (there - clip.root_position[i]).norm();
            assert!(apart < 0.005, "frame {i}: {apart} m");
            let angle = (facing * back.clip.root_orientation[i]).angle_to(&clip.root_orientation[i]);
            assert!(angle < 0.005, "frame {i}: {angle} rad");
        }
        let signs = back.clip.root_orientation.windows(2).all(|w| w[0].coords.dot(&w[1].coords) > 0.0);
        assert!(signs, "no sign flips");
    }

    #[test]
    fn half_the_pace_is_half_the_path_and_half_the_turn() {
        let robot = Robot::load("lima").unwrap();
        let size = robot.layout.size();
        let mut row = vec![0.0; size];
        row[FeatureLayout::ORIENTATION].copy_from_slice(&to_6d(&Quat::from_euler_angles(0.0, 0.3, 0.2)));
        row[7] = 1.0;
        let end = |row: &[f64], pace| {
            let back = unroll(&row.repeat(51), &[pace; 51], &robot.layout, 50.0, &robot.character).unwrap();
            (back.clip.root_position[50], heading_angle(&back.clip.root_orientation[50]))
        };
        assert!((end(&row, 1.0).0 - Vec3::x()).norm() < 1e-9, "straight on at 1 m/s for 1 s");
        assert!((end(&row, 0.5).0 - Vec3::x() * 0.5).norm() < 1e-9);
        assert!(end(&row, 1.0).1.abs() < 1e-9, "what is left of a heading is no turn");
        row[12] = 1.0;
        assert!((end(&row, 1.0).1 - 1.0).abs() < 1e-9 && (end(&row, 0.5).1 - 0.5).abs() < 1e-9);
    }

    #[test]
    fn joints_stay_in_their_ranges() {
        let robot = Robot::load("lima").unwrap();
        let clip = curve(&robot, 50.0);
        let back = unroll(&features(&robot, &clip), &[1.0; 200], &robot.layout, 50.0, &robot.character).unwrap();
        assert_eq!(back.clamped, 1.0);
        let highest: Vec<f64> = robot.character.scalar_joints().map(|j| j.range.unwrap().1).collect();
        assert_eq!(back.clip.joints_at(7), highest);
        let furthest = clip.joints_at(0).iter().zip(&highest).map(|(q, h)| q - h).fold(0.0, f64::max);
        assert!((back.excess - furthest).abs() < 1e-12);
    }

    #[test]
    fn nonsense_is_told() {
        let robot = Robot::load("lima").unwrap();
        let size = robot.layout.size();
        let of = |features: &[f64], pace: &[f64], layout: &FeatureLayout| {
            unroll(features, pace, layout, 50.0, &robot.character).unwrap_err().to_string()
        };
        assert!(of(&vec![0.0; size], &[1.0], &robot.layout).contains("frame 0"), "an orientation of zeros");
        assert!(of(&vec![0.0; size], &[1.0; 2], &robot.layout).contains("2 rows"));
        assert!(of(&[], &[], &robot.layout).contains("at least one"));
        let mut other = robot.layout.clone();
        other.joints[0] = "tail".into();
        assert!(of(&vec![0.0; size], &[1.0], &other).contains("tail"));
    }
}
