//! HumanML3D (Guo et al. 2022): motion of SMPL's 22 joints at 20 frames per second, y up, as one `.npy`.
//!
//! Two kinds of files are read. `new_joint_vecs` has 263 features a frame, of which the first 67 say where the joints
//! are: the root's turn (half angle per frame) and velocity in its own heading, its height, and the other joints
//! beside it. `new_joints` has the positions themselves, `[frames, 22, 3]`.
//!
//! Positions have no twist about a bone. A joint with several children turns as they do; any other turns from its
//! parent by the shortest way.

use std::path::Path;

use lifelike_character::{Mat3, Quat, Vec3};

use super::amass::body;
use super::raw::{self, RawClip};
use super::standing::Known;
use super::{Format, ReadOptions, Reader, clip_name, npz, rest};
use crate::error::MotionError;
use crate::source::SourceClip;

/// The format, for the table of all.
pub const FORMAT: Format = Format {
    name: "HumanML3D",
    suffixes: &[],
    shared_suffixes: &[".npy"],
    companion: "",
    // Mean and deviation of the features lie beside the motions.
    not_motion: &["mean.npy", "std.npy"],
    clip_name: |_| None,
    sniff: |sample| {
        sample.start.starts_with(b"\x93NUMPY")
            && [", 263)", ", 22, 3)"].iter().any(|shape| contains(&sample.start, shape))
    },
    reader: Reader::Source(parse),
};

/// Frames per second of the data set.
const FPS: f64 = 20.0;
/// Features of a frame.
const FEATURES: usize = 263;
/// Features that say where the joints are.
const PLACES: usize = 4 + 3 * 21;
const JOINTS: usize = 22;
/// An hour at 120 frames per second.
const MOST_FRAMES: usize = 432_000;

fn contains(start: &[u8], text: &str) -> bool {
    start.windows(text.len()).any(|window| window == text.as_bytes())
}

/// Reads a file of features or of positions. `file` is for names and messages only.
///
/// # Errors
/// [`MotionError::Input`] for another shape.
pub fn parse(bytes: &[u8], file: &Path, options: &ReadOptions) -> Result<SourceClip, MotionError> {
    let array = npz::single(bytes, file)?;
    let frames = match *array.shape() {
        [frames, FEATURES] | [frames, JOINTS, 3] if (1..=MOST_FRAMES).contains(&frames) => frames,
        _ => return Err(array.wrong_shape(&format!("of shape [frames, {FEATURES}] or [frames, {JOINTS}, 3]"))),
    };
    let has_features = array.shape().len() == 2;
    let numbers = array.select(|_, column| !has_features || column < PLACES)?;
    let places: Vec<Vec<Vec3>> = match has_features {
        true => places_of(&numbers),
        false => numbers.chunks_exact(3 * JOINTS).map(vectors).collect(),
    };
    debug_assert_eq!(places.len(), frames);
    let turns: Vec<Vec<Quat>> = places.iter().map(|places| turns(places)).collect();
    let rotations = turns.iter().map(|turns| locals(turns)).collect();
    let joints = &body::JOINTS;
    let raw = RawClip {
        name: clip_name(file),
        provenance: "HumanML3D (github.com/EricGuo5513/HumanML3D), from AMASS, non-commercial research only".to_owned(),
        fps: options.fps.unwrap_or(FPS),
        cyclic: false,
        names: joints.iter().map(|(name, ..)| (*name).to_owned()).collect(),
        parents: joints.iter().map(|(_, parent, _)| *parent).collect(),
        offsets: offsets(&places, &turns),
        ends: body::HANDS.map(|(wrist, offset)| (wrist, Vec3::from(offset))).to_vec(),
        known: Some(Known { basis: raw::from_y_up_z_forward(), rest: vec![Quat::identity(); JOINTS] }),
        hints: rest::Hints::default(),
        root_position: places.iter().map(|places| places[0]).collect(),
        rotations,
        notes: Vec::new(),
    };
    raw.finish(options)
}

fn vectors(numbers: &[f64]) -> Vec<Vec3> {
    numbers.as_chunks::<3>().0.iter().map(|place| Vec3::from(*place)).collect()
}

/// Returns the joints' positions from the features: turn and path of the root are sums of those of the frames before.
fn places_of(features: &[f64]) -> Vec<Vec<Vec3>> {
    let (mut half_angle, mut path) = (0.0, Vec3::zeros());
    let mut before: Option<&[f64]> = None;
    let mut places = Vec::with_capacity(features.len() / PLACES);
    for frame in features.chunks_exact(PLACES) {
        half_angle += before.map_or(0.0, |before| before[0]);
        let heading = Quat::from_axis_angle(&Vec3::y_axis(), -2.0 * half_angle);
        path += before.map_or_else(Vec3::zeros, |before| heading * Vec3::new(before[1], 0.0, before[2]));
        let root = path + Vec3::y() * frame[3];
        places.push(
            std::iter::once(root).chain(vectors(&frame[4..]).iter().map(|place| path + heading * place)).collect(),
        );
        before = Some(frame);
    }
    places
}

/// Returns the children of a joint.
fn children(joint: usize) -> impl Iterator<Item = usize> {
    (0..JOINTS).filter(move |child| body::JOINTS[*child].1 == Some(joint))
}

/// Returns the rotation of each joint since the rest pose, from positions.
fn turns(places: &[Vec3]) -> Vec<Quat> {
    let mut turns: Vec<Quat> = Vec::with_capacity(JOINTS);
    for joint in 0..JOINTS {
        let parent = body::JOINTS[joint].1.map_or_else(Quat::identity, |parent| turns[parent]);
        let bones: Vec<(Vec3, Vec3)> =
            children(joint).map(|child| (Vec3::from(body::JOINTS[child].2), places[child] - places[joint])).collect();
        turns.push(match bones.as_slice() {
            [] => parent,
            [(rest, now)] => Quat::rotation_between(&(parent * rest), now).unwrap_or_else(Quat::identity) * parent,
            several => nearest(several).unwrap_or(parent),
        });
    }
    turns
}

/// Returns the rotation that brings several bones nearest to where they are (Kabsch).
fn nearest(bones: &[(Vec3, Vec3)]) -> Option<Quat> {
    let covariance: Mat3 = bones.iter().map(|(rest, now)| now * rest.transpose()).sum();
    let svd = covariance.svd(true, true);
    let (u, v) = (svd.u?, svd.v_t?);
    let handed = Mat3::from_diagonal(&Vec3::new(1.0, 1.0, (u * v).determinant().signum()));
    Some(Quat::from_matrix(&(u * handed * v)))
}

fn locals(turns: &[Quat]) -> Vec<Quat> {
    let local =
        |joint: usize| body::JOINTS[joint].1.map_or(turns[joint], |parent| turns[parent].inverse() * turns[joint]);
    (0..JOINTS).map(local).collect()
}

/// Returns the mean offset of each joint in its parent's frame (m).
fn offsets(places: &[Vec<Vec3>], turns: &[Vec<Quat>]) -> Vec<Vec3> {
    let mean = |joint: usize, parent: usize| {
        let frames = places.iter().zip(turns);
        let sum: Vec3 = frames.map(|(places, turns)| turns[parent].inverse() * (places[joint] - places[parent])).sum();
        sum / places.len() as f64
    };
    (0..JOINTS).map(|joint| body::JOINTS[joint].1.map_or_else(Vec3::zeros, |parent| mean(joint, parent))).collect()
}
