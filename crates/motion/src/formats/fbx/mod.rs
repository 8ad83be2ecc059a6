//! FBX: the skeleton and one take of a scene, evaluated at the file's rate by `ufbx`.
//!
//! Axes and unit come from the file; the result is y up and in metres before the rest pose is brought to ours. A joint's
//! frame is turned so that it is aligned with the world in the file's bind pose. Without one the standing pose is found
//! from the motion. Bones have the lengths of the first frame.

use std::path::Path;

use lifelike_character::{Quat, Vec3};

use super::raw::RawClip;
use super::{Format, ReadOptions, Reader, clip_name, rest};
use crate::roles::{self, Tree};
use crate::source::SourceClip;
use crate::{FromInput, MotionError};

mod joints;
mod take;
mod whole;

use joints::Joints;
use take::Take;

/// Most memory that a scene takes, once while it is read and once as it stays (bytes).
const MOST_MEMORY: usize = 1 << 30;
/// Sizes of a skeleton that is read (m).
const SIZES: std::ops::RangeInclusive<f64> = 0.1..=20.0;
/// Deepest tree of nodes.
const DEEPEST: u32 = 1000;
/// Way of a joint in its parent's frame (m) from which another joint may hold it.
const HELD: f64 = 0.002;
/// Change of a bone's length that a user should know of, as a part of the longest bone.
const STRETCH: f64 = 0.05;

/// The format, for the table of all.
pub const FORMAT: Format = Format {
    name: "FBX",
    suffixes: &[".fbx"],
    shared_suffixes: &[],
    companion: "",
    not_motion: &[],
    clip_name: |_| None,
    sniff: |sample| sample.start.starts_with(b"Kaydara FBX Binary") || sample.start.starts_with(b"; FBX "),
    reader: Reader::Source(parse),
};

/// Reads an FBX file. `file` is for names and messages only.
///
/// # Errors
/// [`MotionError::Input`] for a file that is broken, has no skeleton or no take, or is too large.
pub fn parse(bytes: &[u8], file: &Path, options: &ReadOptions) -> Result<SourceClip, MotionError> {
    let wrong = |(expected, got): (String, String)| MotionError::format(file.display(), expected, got);
    if options.scale.is_some() || options.skip_frames.is_some() || options.angles.is_some() {
        let got = "--scale, --skip-frames or --angles: FBX says its unit and has no such frames".to_owned();
        return Err(wrong(("no options of BVH".to_owned(), got)));
    }
    let scene = load(bytes).map_err(wrong)?;
    let mut notes = Vec::new();
    let joints = Joints::find(&scene, &mut notes).map_err(wrong)?;
    let take = Take::choose(&scene, &mut notes).map_err(wrong)?;
    let motion = take.sample(&joints, options.fps).map_err(wrong)?;
    let size = size(&motion.places[0]);
    if !SIZES.contains(&size) {
        let got = format!("{size:.3} m: the unit that the file says is another one; export it anew");
        return Err(wrong((format!("a skeleton of {} to {} m", SIZES.start(), SIZES.end()), got)));
    }
    assemble(clip_name(file), &joints, &motion, notes).finish(options)
}

/// Returns the longest edge of the box around all joints (m).
fn size(places: &[Vec3]) -> f64 {
    let low = places.iter().fold(Vec3::repeat(f64::INFINITY), |low, place| low.inf(place));
    let high = places.iter().fold(Vec3::repeat(f64::NEG_INFINITY), |high, place| high.sup(place));
    (high - low).max()
}

/// Loads a scene without geometry, in metres, with y up.
fn load(bytes: &[u8]) -> Result<ufbx::SceneRoot, (String, String)> {
    const EXPECTED: &str = "a whole FBX file of version 6 or 7";
    if let Some(got) = whole::missing(bytes) {
        return Err((EXPECTED.to_owned(), got));
    }
    let limited = || ufbx::AllocatorOpts { memory_limit: MOST_MEMORY, ..Default::default() };
    let options = ufbx::LoadOpts {
        temp_allocator: limited(),
        result_allocator: limited(),
        ignore_geometry: true,
        ignore_embedded: true,
        node_depth_limit: DEEPEST,
        target_axes: ufbx::CoordinateAxes::right_handed_y_up(),
        target_unit_meters: 1.0,
        inherit_mode_handling: ufbx::InheritModeHandling::Compensate,
        ..Default::default()
    };
    ufbx::load_memory(bytes, options).map_err(|e| {
        let detail = if e.info().is_empty() { String::new() } else { format!(" ({})", e.info()) };
        (EXPECTED.to_owned(), format!("{}{detail}", &*e.description))
    })
}

/// Places and rotations of joints in the world, `[frame][joint]`.
struct Motion {
    fps: f64,
    places: Vec<Vec<Vec3>>,
    turns: Vec<Vec<Quat>>,
}

/// Aligns the joints' frames with the world in the bind pose, and merges the joints above the one that carries the body.
fn assemble(name: String, joints: &Joints<'_>, motion: &Motion, mut notes: Vec<String>) -> RawClip {
    let n = joints.names.len();
    let turns: Vec<Vec<Quat>> = motion.turns.iter().map(|frame| joints.aligned(frame)).collect();
    let parents = holders(joints, motion, &turns);
    let local = |t: usize, joint: usize| match parents[joint] {
        Some(p) => turns[t][p].inverse() * (motion.places[t][joint] - motion.places[t][p]),
        None => motion.places[t][joint],
    };
    let offsets: Vec<Vec3> = (0..n).map(|j| local(0, j)).collect();
    let longest = (0..n).filter(|j| parents[*j].is_some()).map(|j| offsets[j].norm()).fold(0.0, f64::max);
    let moved: Vec<f64> =
        (0..n).map(|j| (0..turns.len()).map(|t| (local(t, j) - offsets[j]).norm()).fold(0.0, f64::max)).collect();
    let moves: Vec<bool> = moved.iter().map(|way| *way > 1e-3 * longest).collect();
    let tree = Tree { names: &joints.names, parents: &parents, offsets: &offsets };
    let root = roles::body_root(tree, &moves, &joints.ends);
    let body = root..roles::end_of(&parents, root);
    let stretched = body.clone().skip(1).max_by(|a, b| moved[*a].total_cmp(&moved[*b]));
    if let Some(joint) = stretched.filter(|joint| moved[*joint] > STRETCH * longest) {
        let (name, way) = (&joints.names[joint], moved[joint]);
        notes.push(format!("bones keep their lengths of the first frame, but '{name}' moves by {way:.2} m"));
    }
    let kept: Vec<usize> = body.filter(|joint| !joints.ends.contains(joint)).collect();
    let place = |joint: usize| kept.binary_search(&joint).ok();
    let rotations = turns.iter().map(|frame| {
        let turn = |j: &usize| parents[*j].filter(|_| *j > root).map_or(frame[*j], |p| frame[p].inverse() * frame[*j]);
        kept.iter().map(turn).collect()
    });
    RawClip {
        name,
        provenance: "FBX".to_owned(),
        fps: motion.fps,
        cyclic: false,
        names: kept.iter().map(|j| joints.names[*j].clone()).collect(),
        parents: kept.iter().map(|j| parents[*j].and_then(place)).collect(),
        offsets: kept.iter().map(|j| offsets[*j]).collect(),
        ends: joints.ends.iter().filter_map(|j| Some((place(parents[*j]?)?, offsets[*j]))).collect(),
        known: None,
        hints: rest::Hints::default(),
        root_position: motion.places.iter().map(|frame| frame[root]).collect(),
        rotations: rotations.collect(),
        notes,
    }
}

/// Returns the parents of the joints. One that moves in its parent's frame hangs on the joint above in whose frame it
/// does not: 3ds Max's thighs are below the spine, and move with the pelvis.
fn holders(joints: &Joints<'_>, motion: &Motion, turns: &[Vec<Quat>]) -> Vec<Option<usize>> {
    let local = |t: usize, joint: usize, parent: usize| {
        turns[t][parent].inverse() * (motion.places[t][joint] - motion.places[t][parent])
    };
    let way = |joint: usize, parent: usize| {
        let first = local(0, joint, parent);
        (0..turns.len()).map(|t| (local(t, joint, parent) - first).norm()).fold(0.0, f64::max)
    };
    let mut parents = joints.parents.clone();
    for joint in 0..parents.len() {
        let Some(parent) = parents[joint] else { continue };
        let moves = way(joint, parent);
        // The topmost joint stays for the place of the whole body.
        let above = std::iter::successors(joints.parents[parent], |joint| joints.parents[*joint]);
        let mut above = above.take_while(|joint| moves > HELD && joints.parents[*joint].is_some());
        if let Some(holder) = above.find(|other| way(joint, *other) < 0.1 * moves) {
            parents[joint] = Some(holder);
        }
    }
    parents
}
