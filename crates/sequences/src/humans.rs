//! Captured people as rows of joint rotations, whatever skeleton they came with (thesis 3.3.3).
//!
//! The thesis reports "per-frame joint positions measured in degrees" and a "mean squared error between joint angles
//! \[deg\]" and says nothing of how angles of ball joints are made numbers; HumanML3D and SMPL are not ours to use. So
//! the definition is ours:
//!
//! - Fifteen segments by their roles ([`SEGMENTS`]), at [`FPS`].
//! - Each segment's rotation relative to its parent's, since the T-pose that all readers bring a skeleton to, as a
//!   ROTATION VECTOR (axis × angle, rad) in the parent's frame: three numbers.
//! - The pelvis relative to the world without its heading (the turn about the vertical): the shortest rotation that
//!   tilts the vertical to where the pelvis' points, which has a level axis: two numbers. (Who passes upside down
//!   sideways turns fast there.)
//! - Unwrapped along the clip: of the vectors of one rotation (whole turns apart) the one that is nearest to the frame
//!   before. A segment that turns past half a turn goes on instead of jumping to the other side. What still jumps are
//!   captures that flip (some of CMU's feet and forearms) and segments that come near a whole turn and leave it about
//!   another axis.
//!
//! The mean squared error is that of all numbers of a row, as they are. The geodesic error is the angle of the
//! rotation between two poses of a segment, mean over segments and frames.

use lifelike_character::{Quat, Role, Vec3};
use lifelike_motion::resample::{locate, slerp};
use lifelike_motion::retarget::{Correspondence, SourceRoles};
use lifelike_motion::{MotionError, SourceClip};

use crate::SequencesError;
use lifelike_representation::spline_transformer::Recording;

/// Frames per second of every recording.
pub const FPS: f64 = 30.0;
/// Numbers of a frame: two of the pelvis and three of each other segment.
pub const WIDTH: usize = 2 + 3 * SEGMENTS.len();

/// Segments with the segment that they are measured from, in the order of a row after the pelvis' two numbers.
pub const SEGMENTS: [(Role, Role); 14] = [
    (Role::Chest, Role::Pelvis),
    (Role::Head, Role::Chest),
    (Role::LeftThigh, Role::Pelvis),
    (Role::LeftShank, Role::LeftThigh),
    (Role::LeftFoot, Role::LeftShank),
    (Role::RightThigh, Role::Pelvis),
    (Role::RightShank, Role::RightThigh),
    (Role::RightFoot, Role::RightShank),
    (Role::LeftUpperArm, Role::Chest),
    (Role::LeftForearm, Role::LeftUpperArm),
    (Role::LeftHand, Role::LeftForearm),
    (Role::RightUpperArm, Role::Chest),
    (Role::RightForearm, Role::RightUpperArm),
    (Role::RightHand, Role::RightForearm),
];

/// Returns a captured clip as rows of [`WIDTH`] angles (rad) at [`FPS`].
///
/// # Errors
/// A clip that is not one, or without one of the segments.
pub fn recording(clip: &SourceClip) -> Result<Recording, SequencesError> {
    clip.check()?;
    let roles = SourceRoles::guess(clip, &Correspondence::default())?;
    let joint = |role: Role| {
        let message = || format!("no {role:?} among the joints: {}", clip.skeleton.names.join(", "));
        roles.get(role).ok_or_else(|| MotionError::Unfit { clip: clip.name.clone(), message: message() })
    };
    let pelvis = joint(Role::Pelvis)?;
    let mut pairs = Vec::with_capacity(SEGMENTS.len());
    for (segment, parent) in SEGMENTS {
        pairs.push((joint(segment)?, joint(parent)?));
    }
    // Pelvis first.
    let pose = |frame: usize| -> Vec<Quat> {
        let (_, world) = clip.pose(frame);
        let relative = pairs.iter().map(|(segment, parent)| world[*parent].inverse() * world[*segment]);
        std::iter::once(world[pelvis]).chain(relative).collect()
    };
    let frames = (clip.seconds() * FPS + 1e-6).floor() as usize + 1;
    let (mut last, mut heading) = (vec![Vec3::zeros(); SEGMENTS.len() + 1], Quat::identity());
    let mut rows = Vec::with_capacity(frames * WIDTH);
    for t in 0..frames {
        let (before, share) = locate(t as f64 / FPS * clip.fps, clip.len());
        let mut rotations = pose(before);
        if share > 0.0 {
            let after = pose(before + 1);
            rotations.iter_mut().zip(&after).for_each(|(a, b)| *a = slerp(a, b, share));
        }
        heading = turn(&rotations[0]).unwrap_or(heading);
        rotations[0] = heading.inverse() * rotations[0];
        for (last, rotation) in last.iter_mut().zip(&rotations) {
            *last = nearest(rotation.scaled_axis(), *last);
        }
        rows.extend(
            last.iter().enumerate().flat_map(|(i, v)| v.iter().take(if i == 0 { 2 } else { 3 })).map(|x| *x as f32),
        );
    }
    Ok(Recording { name: clip.name.clone(), rows })
}

/// Returns the mean angle (deg) of the rotations between the segments of two rows or more, both `[frames, WIDTH]`.
pub fn geodesic_error(a: &[f32], b: &[f32]) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for (a, b) in a.chunks_exact(WIDTH).zip(b.chunks_exact(WIDTH)) {
        for (a, b) in rotations(a).zip(rotations(b)) {
            sum += a.angle_to(&b).to_degrees();
            count += 1;
        }
    }
    sum / f64::from(count)
}

/// Pelvis and segments of one row.
fn rotations(row: &[f32]) -> impl Iterator<Item = Quat> + '_ {
    let (pelvis, segments) = row.split_at(2);
    let pelvis = Vec3::new(f64::from(pelvis[0]), f64::from(pelvis[1]), 0.0);
    let segments = segments.as_chunks::<3>().0.iter().map(|v| Vec3::from(v.map(f64::from)));
    std::iter::once(pelvis).chain(segments).map(Quat::from_scaled_axis)
}

/// Returns the turn about the vertical in a rotation: without it, what is left is about a level axis. Of someone
/// exactly upside down every turn would do.
fn turn(q: &Quat) -> Option<Quat> {
    Quat::try_new(nalgebra::Quaternion::new(q.w, 0.0, 0.0, q.k), 1e-6)
}

/// Returns the rotation vector of `v`'s rotation that is nearest to `last`.
fn nearest(v: Vec3, last: Vec3) -> Vec3 {
    // Of no rotation any axis will do: that of whole turns so far.
    let Some(axis) = v.try_normalize(1e-9).or_else(|| last.try_normalize(1e-9)) else { return v };
    let turns = (axis.dot(&(last - v)) / std::f64::consts::TAU).round();
    v + axis * (turns * std::f64::consts::TAU)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::f64::consts::{FRAC_PI_2, PI};

    use lifelike_motion::Skeleton;

    use super::*;

    const NAMES: [(&str, Option<usize>); 16] = [
        ("hips", None),
        ("chest", Some(0)),
        ("head", Some(1)),
        ("leftThigh", Some(0)),
        ("leftShin", Some(3)),
        ("leftFoot", Some(4)),
        ("rightThigh", Some(0)),
        ("rightShin", Some(6)),
        ("rightFoot", Some(7)),
        ("leftShoulder", Some(1)),
        ("leftUpperArm", Some(9)),
        ("leftForearm", Some(10)),
        ("leftHand", Some(11)),
        ("rightUpperArm", Some(1)),
        ("rightForearm", Some(13)),
        ("rightHand", Some(14)),
    ];

    /// Returns a clip whose rotations are `turn(time, joint)`.
    fn clip(fps: f64, frames: usize, turn: impl Fn(f64, &str) -> Quat) -> SourceClip {
        let at = |t: usize| NAMES.iter().map(|(name, _)| turn(t as f64 / fps, name)).collect();
        SourceClip {
            name: "one".into(),
            fps,
            skeleton: Skeleton {
                names: NAMES.map(|(name, _)| name.into()).to_vec(),
                parents: NAMES.map(|(_, parent)| parent).to_vec(),
                offsets: vec![Vec3::z(); 16],
                ends: vec![],
            },
            root_position: vec![Vec3::zeros(); frames],
            rotations: (0..frames).map(at).collect(),
            cyclic: false,
            captions: vec![],
            provenance: String::new(),
        }
    }

    fn about(axis: Vec3, angle: f64) -> Quat {
        Quat::from_scaled_axis(axis * angle)
    }

    #[track_caller]
    fn near(got: &[f32], expected: [f64; 3]) {
        assert!(got.iter().zip(expected).all(|(g, e)| (f64::from(*g) - e).abs() < 1e-5), "{got:?}, not {expected:?}");
    }

    /// Returns the columns of a segment's numbers.
    fn at(row: &[f32], segment: Role) -> &[f32] {
        let i = SEGMENTS.iter().position(|(s, _)| *s == segment).unwrap();
        &row[2 + 3 * i..][..3]
    }

    #[test]
    fn angles_of_a_clip_made_by_hand() {
        // Turned about the vertical and bent forward; the left knee bends at 1 rad/s, shoulder and upper arm add up.
        let turn = |t: f64, name: &str| match name {
            "hips" => about(Vec3::z(), 2.0) * about(Vec3::y(), 0.3),
            "leftShin" => about(Vec3::y(), t),
            "leftShoulder" => about(Vec3::x(), 0.1),
            "leftUpperArm" => about(Vec3::x(), 0.5),
            _ => Quat::identity(),
        };
        // 40 frames a second: every other of ours lies between two.
        let found = recording(&clip(40.0, 41, turn)).unwrap();
        assert_eq!((found.name.as_str(), found.rows.len()), ("one", 31 * WIDTH));
        for (i, row) in found.rows.chunks(WIDTH).enumerate() {
            near(&row[..2], [0.0, 0.3, 0.0]);
            near(at(row, Role::LeftShank), [0.0, i as f64 / 30.0, 0.0]);
            near(at(row, Role::LeftUpperArm), [0.6, 0.0, 0.0]);
            near(at(row, Role::RightShank), [0.0; 3]);
            near(at(row, Role::Chest), [0.0; 3]);
        }
    }

    #[test]
    fn segments_that_turn_around_do_not_jump() {
        // A forward roll, and an arm that swings around twice.
        let turn = |t: f64, name: &str| match name {
            "hips" => about(Vec3::z(), 1.0) * about(Vec3::y(), 1.5 * PI * t),
            "rightUpperArm" => about(Vec3::new(0.6, 0.8, 0.0), 4.0 * PI * t),
            _ => Quat::identity(),
        };
        let rows = recording(&clip(120.0, 121, turn)).unwrap().rows;
        for (i, row) in rows.chunks(WIDTH).enumerate() {
            let t = i as f64 / 30.0;
            near(&row[..2], [0.0, 1.5 * PI * t, 0.0]);
            near(at(row, Role::RightUpperArm), [0.6 * 4.0 * PI * t, 0.8 * 4.0 * PI * t, 0.0]);
        }
    }

    #[test]
    fn the_geodesic_error_is_the_angle_between_poses() {
        let still = vec![0.0; 2 * WIDTH];
        let mut bent = still.clone();
        // In one of two frames: the pelvis by a quarter of a turn, another segment by a whole turn, which is none.
        bent[1] = FRAC_PI_2 as f32;
        bent[2 + 3] = std::f32::consts::TAU;
        let error = geodesic_error(&still, &bent);
        assert!((error - 90.0 / 30.0).abs() < 1e-3, "{error}");
        assert_eq!(geodesic_error(&bent, &bent), 0.0);
    }

    #[test]
    fn what_is_no_whole_person_is_refused() {
        let still = |_: f64, _: &str| Quat::identity();
        let mut headless = clip(30.0, 30, still);
        headless.skeleton.names[2] = "box".into();
        let error = recording(&headless).unwrap_err().to_string();
        assert!(error.contains("one") && error.contains("no Head among the joints: hips, chest"), "{error}");
        let mut broken = clip(30.0, 30, still);
        broken.rotations[7].pop();
        assert!(recording(&broken).unwrap_err().to_string().contains("rotations"));
        broken = clip(f64::NAN, 30, still);
        assert!(recording(&broken).is_err());
    }
}
