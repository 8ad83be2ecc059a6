//! BVH (Biovision hierarchy): a skeleton with channels, then one line of numbers per frame.
//!
//! Channels are read per joint, in the order in which the file applies them: a joint's rotation is the product of its
//! rotation channels from first to last, angles in degrees. A chain of single-child joints on top that ends in a joint
//! with position channels (Bandai's static `joint_Root` above `Hips`) is merged into that joint.

use std::path::Path;

use lifelike_character::{Quat, Vec3};

use super::raw::{self, RawClip};
use super::{Format, ReadOptions, Reader, clip_name, text};
use crate::error::MotionError;
use crate::source::SourceClip;

mod convention;
mod hierarchy;

use convention::Convention;
use hierarchy::{Channel, Hierarchy};

/// The format, for the table of all.
pub const FORMAT: Format = Format {
    name: "BVH",
    suffixes: &[".bvh"],
    shared_suffixes: &[],
    companion: "",
    not_motion: &[],
    clip_name: |_| None,
    sniff: |start| start.starts_with(b"HIERARCHY"),
    reader: Reader::Source(parse),
};

/// Reads a BVH file. `file` is for names and messages only.
///
/// # Errors
/// [`MotionError::Parse`] with the line; [`MotionError::Container`] when the unit of length cannot be guessed.
pub fn parse(bytes: &[u8], file: &Path, options: &ReadOptions) -> Result<SourceClip, MotionError> {
    let content = text::decode(bytes, file)?;
    let mut lines = text::Lines::new(content, file);
    let hierarchy = Hierarchy::parse(&mut lines)?;
    let convention = Convention::of(&hierarchy);

    let frames = lines.expect("'Frames: <count>'")?;
    let frames: usize = match frames.strip_prefix("Frames:").map(|n| n.trim().parse()) {
        Some(Ok(frames)) => frames,
        _ => return Err(lines.error("'Frames: <count>'", frames)),
    };
    let count_line = lines.number();
    let time = lines.expect("'Frame Time: <seconds>'")?;
    let time = lines.number_in(time.strip_prefix("Frame Time:").map(str::trim), "'Frame Time: <seconds>'")?;
    if time <= 1e-5 {
        return Err(lines.error("a frame time above 0.00001 s", &time.to_string()));
    }

    let skip = options.skip_frames.unwrap_or_else(|| convention.rest_frames());
    let root = hierarchy.root();
    let mut motion = Motion { root_position: Vec::new(), rotations: Vec::new() };
    let mut offsets: Vec<Vec3> = hierarchy.joints.iter().map(|j| j.offset).collect();
    let mut channels = vec![0.0; hierarchy.joints.iter().map(|j| j.channels.len()).sum()];
    let mut seen = 0_usize;
    while let Some(line) = lines.next_line() {
        if seen == frames {
            return Err(lines.error(format!("{frames} frames, as line {count_line} says"), "one more"));
        }
        let mut tokens = line.split_ascii_whitespace();
        for value in &mut channels {
            *value = lines.number_in(tokens.next(), "a number for each channel")?;
        }
        if let Some(extra) = tokens.next() {
            return Err(lines.error(format!("{} numbers", channels.len()), extra));
        }
        if seen >= skip {
            motion.push(&hierarchy, root, &channels, &mut offsets);
        }
        seen += 1;
    }
    if seen < frames {
        let got = format!("the end of the file after {seen}");
        return Err(text::parse_error(
            file,
            lines.number(),
            format!("{frames} frames, as line {count_line} says"),
            &got,
        ));
    }
    if motion.root_position.is_empty() {
        let got = format!("{frames} of which {skip} are left out");
        return Err(text::parse_error(file, count_line, "at least one frame of motion", &got));
    }
    assemble(file, options, &hierarchy, convention, offsets, raw::rate(time), motion)
}

/// Motion in the file's axes and unit, joints from the (merged) root on.
struct Motion {
    root_position: Vec<Vec3>,
    rotations: Vec<Vec<Quat>>,
}

impl Motion {
    /// Adds a frame. The first one also fixes the offsets of joints that have position channels of their own.
    fn push(&mut self, hierarchy: &Hierarchy, root: usize, channels: &[f64], offsets: &mut [Vec3]) {
        let first = self.root_position.is_empty();
        let mut values = channels.iter();
        let (mut position, mut orientation) = (Vec3::zeros(), Quat::identity());
        let mut rotations = Vec::with_capacity(hierarchy.joints.len() - root);
        for (at, joint) in hierarchy.joints.iter().enumerate() {
            let mut place = joint.offset;
            let mut rotation = Quat::identity();
            for (channel, value) in joint.channels.iter().zip(&mut values) {
                match channel {
                    Channel::Position(axis) => place[*axis] = *value,
                    Channel::Rotation(axis) => rotation *= raw::about(*axis, value.to_radians()),
                }
            }
            if at <= root {
                position += orientation * place;
                orientation *= rotation;
                if at == root {
                    rotations.push(orientation);
                }
            } else {
                if first {
                    offsets[at] = place;
                }
                rotations.push(rotation);
            }
        }
        self.root_position.push(position);
        self.rotations.push(rotations);
    }
}

/// Merges the joints above the root, and changes unit, axes and rest pose.
fn assemble(
    file: &Path,
    options: &ReadOptions,
    hierarchy: &Hierarchy,
    convention: Convention,
    mut offsets: Vec<Vec3>,
    fps: f64,
    mut motion: Motion,
) -> Result<SourceClip, MotionError> {
    let root = hierarchy.root();
    offsets.drain(..root);
    let joints = &hierarchy.joints[root..];
    let parents: Vec<Option<usize>> =
        joints.iter().enumerate().map(|(at, j)| j.parent.filter(|_| at > 0).map(|p| p - root)).collect();
    let rest = convention.rest(joints);
    let mut ends: Vec<(usize, Vec3)> =
        hierarchy.ends.iter().filter(|(j, _)| *j >= root).map(|(j, o)| (j - root, *o)).collect();

    let scale = match options.scale {
        Some(scale) => scale,
        None => guess_scale(file, &rest, &parents, &offsets, &ends)?,
    };
    let scaled = offsets.iter_mut().chain(ends.iter_mut().map(|(_, o)| o)).chain(motion.root_position.iter_mut());
    scaled.for_each(|v| *v *= scale);
    let raw = RawClip {
        name: clip_name(file),
        provenance: convention.provenance().to_owned(),
        fps,
        cyclic: false,
        names: joints.iter().map(|j| j.name.clone()).collect(),
        basis: convention.basis(joints, &parents, &offsets),
        parents,
        offsets,
        ends,
        rest,
        hints: convention.hints(joints),
        root_position: motion.root_position,
        rotations: motion.rotations,
    };
    Ok(raw.finish(options.t_pose))
}

/// Returns the metres per unit, from the longest side of the box around the rest pose: a body of 1 to 2.5 m in m, cm or
/// mm.
fn guess_scale(
    file: &Path,
    rest: &[Quat],
    parents: &[Option<usize>],
    offsets: &[Vec3],
    ends: &[(usize, Vec3)],
) -> Result<f64, MotionError> {
    let mut places: Vec<Vec3> = Vec::with_capacity(offsets.len() + ends.len());
    for (offset, parent) in offsets.iter().zip(parents) {
        places.push(parent.map_or_else(Vec3::zeros, |p| places[p] + rest[p] * offset));
    }
    for (joint, offset) in ends {
        places.push(places[*joint] + rest[*joint] * offset);
    }
    let low = places.iter().fold(Vec3::zeros(), |a, b| a.inf(b));
    let high = places.iter().fold(Vec3::zeros(), |a, b| a.sup(b));
    let size = (high - low).max();
    [1.0, 0.01, 0.001].into_iter().find(|scale| (1.0..2.5).contains(&(size * scale))).ok_or_else(|| {
        MotionError::Container {
            file: file.to_path_buf(),
            expected: "a skeleton of 1 to 2.5 m in m, cm or mm (state the scale otherwise)".to_owned(),
            got: format!("one of {size} units"),
        }
    })
}
