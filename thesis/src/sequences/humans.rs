//! Captured people as rows of joint rotations, whatever skeleton they came with (thesis 3.3.3).
//!
//! The thesis reports "per-frame joint positions measured in degrees" and a "mean squared error between joint angles
//! \[deg\]". It does not state its representation of ball joints, and HumanML3D and SMPL are not ours to use. The
//! definition is therefore ours:
//!
//! - Fifteen segments by their roles ([`SEGMENTS`]), at [`FPS`].
//! - Each segment's rotation relative to its parent's, from the common T-pose of all readers. The pelvis' rotation is
//!   relative to the world, without its heading (the turn about the vertical). Each is in the continuous 6D
//!   representation of Zhou et al. 2019: the first two columns of its matrix. A rotation vector would jump at half a
//!   turn.
//!
//! The error of a segment is the angle of the rotation between its two poses ([`angles`]), in any representation.
//! Reported are means of it and of its square.

use lifelike_character::rotation::{from_6d, to_6d};
use lifelike_character::{Quat, Role};
use lifelike_motion::resample::{locate, slerp};
use lifelike_motion::retarget::{Correspondence, SourceRoles};
use lifelike_motion::{MotionError, SourceClip};

use super::SequencesError;
use lifelike_representation::spline_transformer::Recording;

/// Frames per second of every recording.
pub const FPS: f64 = 30.0;
/// Numbers of a frame: six of the pelvis and of each other segment.
pub const WIDTH: usize = 6 * (1 + SEGMENTS.len());

/// Segments with the segment that they are measured from, in the order of a row after the pelvis.
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

/// Returns a captured clip as rows of [`WIDTH`] numbers at [`FPS`].
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
    let mut heading = Quat::identity();
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
        rows.extend(rotations.iter().flat_map(to_6d).map(|x| x as f32));
    }
    Ok(Recording { name: clip.name.clone(), rows })
}

/// Returns the angles (rad) of the rotations between the segments of two sets of rows, frame after frame, pelvis first. Six numbers that
/// are no rotation (zero or parallel columns) count as half a turn.
///
/// # Shapes
/// Both `[frames, WIDTH]`, to `[frames, 1 + SEGMENTS.len()]`.
pub fn angles<'a>(a: &'a [f32], b: &'a [f32]) -> impl Iterator<Item = f64> + 'a {
    let rotation = |numbers: &[f32; 6]| from_6d(numbers.map(f64::from));
    let angle = move |(a, b): (&[f32; 6], &[f32; 6])| match (rotation(a), rotation(b)) {
        (Some(a), Some(b)) => a.angle_to(&b),
        _ => std::f64::consts::PI,
    };
    a.as_chunks::<6>().0.iter().zip(b.as_chunks::<6>().0).map(angle)
}

/// Returns the turn about the vertical in a rotation: without it, what is left is about a level axis. Of someone
/// exactly upside down every turn would do.
fn turn(q: &Quat) -> Option<Quat> {
    Quat::try_new(nalgebra::Quaternion::new(q.w, 0.0, 0.0, q.k), 1e-6)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::f64::consts::{FRAC_PI_2, PI};

    use lifelike_character::Vec3;
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
            notes: vec![],
        }
    }

    fn about(axis: Vec3, angle: f64) -> Quat {
        Quat::from_scaled_axis(axis * angle)
    }

    #[track_caller]
    fn near(row: &[f32], segment: Option<Role>, expected: Vec3) {
        let i = segment.map_or(0, |s| 1 + SEGMENTS.iter().position(|(segment, _)| *segment == s).unwrap());
        let numbers: [f32; 6] = row[6 * i..][..6].try_into().unwrap();
        let got = from_6d(numbers.map(f64::from)).unwrap();
        assert!(got.angle_to(&Quat::from_scaled_axis(expected)) < 1e-5, "{:?}, not {expected:?}", got.scaled_axis());
    }

    #[test]
    fn rotations_of_a_clip_made_by_hand() {
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
            near(row, None, 0.3 * Vec3::y());
            near(row, Some(Role::LeftShank), i as f64 / 30.0 * Vec3::y());
            near(row, Some(Role::LeftUpperArm), 0.6 * Vec3::x());
            near(row, Some(Role::RightShank), Vec3::zeros());
            near(row, Some(Role::Chest), Vec3::zeros());
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
        for (before, row) in rows.chunks(WIDTH).zip(rows.chunks(WIDTH).skip(1)).skip(1) {
            // A thirtieth of 4 pi a second is 0.42 rad; the heading may turn round where the pelvis is upside down.
            let arm = 6 * (1 + SEGMENTS.iter().position(|(s, _)| *s == Role::RightUpperArm).unwrap());
            let far = before[arm..arm + 6].iter().zip(&row[arm..arm + 6]).map(|(a, b)| (a - b).powi(2)).sum::<f32>();
            assert!(far.sqrt() < 0.6, "{far}");
        }
    }

    #[test]
    fn angles_between_poses_by_hand() {
        let still: Vec<f32> = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0].repeat(2 * (1 + SEGMENTS.len()));
        let mut bent = still.clone();
        // In one of two frames: the pelvis by a quarter of a turn, the next segment by columns that are too long, which is none.
        let quarter = to_6d(&about(Vec3::y(), FRAC_PI_2)).map(|x| x as f32);
        bent[..6].copy_from_slice(&quarter);
        bent[6..12].copy_from_slice(&[3.0, 0.0, 0.0, 1.0, 0.5, 0.0]);
        // And one that is no rotation.
        bent[12..18].fill(0.0);
        let found: Vec<f64> = angles(&still, &bent).collect();
        assert_eq!(found.len(), 2 * (1 + SEGMENTS.len()));
        assert!((found[0] - FRAC_PI_2).abs() < 1e-6 && found[1] < 1e-6 && found[2] == PI, "{found:?}");
        assert!(found[3..].iter().all(|angle| *angle < 1e-6), "{found:?}");
    }

    #[test]
    fn what_is_no_whole_person_is_refused() {
        let still = |_: f64, _: &str| Quat::identity();
        let mut headless = clip(30.0, 30, still);
        headless.skeleton.names[2] = "box".into();
        // A head whose name says nothing is found by its place.
        let named = recording(&clip(30.0, 30, still)).unwrap();
        assert_eq!(recording(&headless).unwrap().rows, named.rows);
        let mut broken = clip(30.0, 30, still);
        broken.rotations[7].pop();
        assert!(recording(&broken).unwrap_err().to_string().contains("rotations"));
        broken = clip(f64::NAN, 30, still);
        assert!(recording(&broken).is_err());
    }
}
