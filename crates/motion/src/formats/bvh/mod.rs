//! BVH (Biovision hierarchy): a skeleton with channels, then one line of numbers per frame.
//!
//! Channels are read per joint, in the order in which the file applies them: a joint's rotation is the product of its
//! rotation channels from first to last, angles in degrees. Joints above the one that carries the body (Bandai's static
//! `joint_Root`, Unreal's `root`) are merged into that joint.

use std::collections::BTreeMap;
use std::path::Path;

use lifelike_character::{Quat, Vec3};

use super::raw::{self, RawClip};
use super::text::{self, Lines};
use super::{Angles, Format, ReadOptions, Reader, clip_name};
use crate::roles::{self, Tree};
use crate::source::SourceClip;
use crate::{FromInput, MotionError};

mod convention;
mod frames;
mod header;
mod hierarchy;
mod rest_frames;
mod unit;

use convention::Convention;
use frames::Numbers;
use header::Header;
use hierarchy::{Channel, Hierarchy};
use rest_frames::Frames;

/// Most rotations of a clip, all joints and frames together (1 GB): an hour of 60 joints at 120 frames per second.
const MOST_ROTATIONS: usize = 30_000_000;
/// Most frames of a clip: an hour and more at 240 frames per second.
const MOST_FRAMES: usize = 1_000_000;
/// Farthest way of the root from frame to frame, as a multiple of the length of all bones.
const LONGEST_JUMP: f64 = 10.0;

/// The format, for the table of all.
pub const FORMAT: Format = Format {
    name: "BVH",
    suffixes: &[".bvh"],
    shared_suffixes: &[],
    companion: "",
    not_motion: &[],
    clip_name: |_| None,
    sniff: |sample| sample.start.get(..9).is_some_and(|word| word.eq_ignore_ascii_case(b"HIERARCHY")),
    reader: Reader::Source(parse),
};

/// Reads a BVH file. `file` is for names and messages only.
///
/// # Errors
/// [`MotionError::Parse`] with the line; [`MotionError::Input`] when the unit of length cannot be guessed.
pub fn parse(bytes: &[u8], file: &Path, options: &ReadOptions) -> Result<SourceClip, MotionError> {
    let content = text::decode(bytes, file)?;
    let mut lines = Lines::new(content, file).without_comments(&["#", "//"]);
    let hierarchy = Hierarchy::parse(&mut lines)?;
    let convention = Convention::of(&hierarchy);
    let mut notes = Vec::new();
    let most_frames = MOST_FRAMES.min(MOST_ROTATIONS / hierarchy.joints.len().max(1));
    let header = Header::parse(&mut lines, most_frames, options.fps, &mut notes)?;

    let skip = options.skip_frames.unwrap_or_else(|| convention.rest_frames());
    let read = |angles| Motion::parse(lines.clone(), &hierarchy, &header, skip, angles);
    let mut motion = read(options.angles.unwrap_or(Angles::Degrees))?;
    if options.angles.is_none() && motion.shows_radians(&hierarchy) {
        notes
            .push("no angle is above 6.3 although the body travels: angles were read as radians (--angles)".to_owned());
        motion = read(Angles::Radians)?;
    }
    notes.append(&mut motion.notes);
    if motion.seen > header.frames {
        notes.push(format!("line {} counts {} frames, {} were read", header.line, header.frames, motion.seen));
    }
    if options.skip_frames.is_none() && convention.rest_frames() == 0 {
        let (places, rotations) = (&mut motion.root_position, &mut motion.rotations);
        let frames = Frames { places, rotations, fps: header.fps, notes: &mut notes };
        frames.without_rest_poses().map_err(|gap| {
            let expected = "motion in all frames, or gaps of at most 0.25 s";
            MotionError::format(file.display(), expected, format!("zero rotations in {gap}: cut the file there"))
        })?;
    }
    assemble(file, options, &hierarchy, convention, header.fps, motion, notes)
}

/// Motion in the file's axes and unit, joints from the (merged) root on.
struct Motion {
    root_position: Vec<Vec3>,
    rotations: Vec<Vec<Quat>>,
    /// Offsets of all joints of the file.
    offsets: Vec<Vec3>,
    /// The same in the first frame, where joints have position channels of their own.
    first_places: Vec<Vec3>,
    /// Largest distance of a joint from its first place, and the joint.
    stretch: (f64, usize),
    notes: Vec<String>,
    /// Frames of the file, with those left out.
    seen: usize,
    /// Largest angle, in the file's unit.
    largest_angle: f64,
}

impl Motion {
    /// Reads the frames.
    fn parse(
        lines: Lines<'_>,
        hierarchy: &Hierarchy,
        header: &Header,
        skip: usize,
        angles: Angles,
    ) -> Result<Self, MotionError> {
        let mut motion = Self {
            root_position: Vec::new(),
            rotations: Vec::new(),
            offsets: hierarchy.joints.iter().map(|j| j.offset).collect(),
            first_places: hierarchy.joints.iter().map(|j| j.offset).collect(),
            stretch: (0.0, 0),
            notes: Vec::new(),
            seen: 0,
            largest_angle: 0.0,
        };
        let counted = || format!("{} frames, as line {} says", header.frames, header.line);
        let mut channels = vec![0.0; hierarchy.joints.iter().map(|j| j.channels.len()).sum()];
        let mut numbers = Numbers::new(lines, channels.len(), header.frames);
        while numbers.read(&mut channels)? {
            // Rokoko's exports count one frame too few.
            if motion.seen > header.frames {
                return Err(numbers.lines.error(counted(), "more"));
            }
            motion.seen += 1;
            if motion.seen > skip {
                motion.push(hierarchy, &channels, angles);
                motion.check_jump(&numbers.lines)?;
            }
        }
        let lines = numbers.lines;
        if motion.seen < header.frames {
            return Err(lines.error(counted(), &format!("the end of the file after {}", motion.seen)));
        }
        if motion.root_position.is_empty() {
            let got = format!("{} of which {skip} are left out", header.frames);
            return Err(lines.error_at(header.line, "at least one frame of motion", &got));
        }
        motion.fix_offsets(hierarchy);
        Ok(motion)
    }

    /// Adds a frame. The first one also fixes the offsets of joints that have position channels of their own.
    fn push(&mut self, hierarchy: &Hierarchy, channels: &[f64], angles: Angles) {
        let first = self.root_position.is_empty();
        let root = hierarchy.root;
        let unit = match angles {
            Angles::Degrees => std::f64::consts::PI / 180.0,
            Angles::Radians => 1.0,
        };
        let mut values = channels.iter();
        let (mut position, mut orientation) = (Vec3::zeros(), Quat::identity());
        let mut rotations = Vec::with_capacity(hierarchy.joints.len() - root);
        for (at, joint) in hierarchy.joints.iter().enumerate() {
            let mut place = joint.offset;
            let mut rotation = Quat::identity();
            for (channel, value) in joint.channels.iter().zip(&mut values) {
                match channel {
                    Channel::Position(axis) => place[*axis] = *value,
                    Channel::Rotation(axis) => {
                        self.largest_angle = self.largest_angle.max(value.abs());
                        rotation *= raw::about(*axis, value * unit);
                    }
                }
            }
            if hierarchy.carries_root[at] {
                position += orientation * place;
                orientation *= rotation;
                if at == root {
                    rotations.push(orientation);
                }
            } else if (root..hierarchy.end).contains(&at) {
                let moved = (place - self.first_places[at]).norm();
                if first {
                    self.first_places[at] = place;
                } else if moved > self.stretch.0 {
                    self.stretch = (moved, at);
                }
                rotations.push(rotation);
            }
        }
        self.root_position.push(position);
        self.rotations.push(rotations);
    }

    /// Refuses a root that the last frame moved farther than any body moves: a broken number.
    fn check_jump(&self, lines: &Lines<'_>) -> Result<(), MotionError> {
        let [.., before, now] = self.root_position.as_slice() else { return Ok(()) };
        let length = |places: &[Vec3]| places.iter().map(Vec3::norm).sum::<f64>();
        // Bones of a wrong unit are judged later: the place counts as well.
        let size = length(&self.offsets).max(length(&self.first_places)).max(before.norm());
        let (jump, most) = ((now - before).norm(), LONGEST_JUMP * size);
        if most > 0.0 && jump > most {
            let expected = format!("a root that moves by at most {most:.0} units between frames");
            let got = format!("{jump:.0} units in frame {}: correct the number, or cut the file there", self.seen);
            return Err(lines.error(expected, &got));
        }
        Ok(())
    }

    /// Takes offsets from the position channels of the first frame, where a joint has some. Bones do not change after that.
    fn fix_offsets(&mut self, hierarchy: &Hierarchy) {
        let is_placed = |at: &usize| hierarchy.joints[*at].channels.iter().any(|c| matches!(c, Channel::Position(_)));
        let placed: Vec<usize> = (hierarchy.root + 1..hierarchy.end).filter(is_placed).collect();
        let sum = |places: &[Vec3]| placed.iter().map(|at| places[*at].norm()).sum::<f64>();
        // Some programs write changes of the offsets in place of the offsets.
        let are_changes = sum(&self.first_places) < 0.1 * sum(&self.offsets);
        for at in placed {
            let start = if are_changes { self.offsets[at] } else { Vec3::zeros() };
            self.offsets[at] = start + self.first_places[at];
        }
        if are_changes {
            let note = "positions of joints are zero where their offsets are not: added to the offsets";
            self.notes.push(note.to_owned());
        }
        let longest = self.offsets.iter().map(Vec3::norm).fold(0.0, f64::max);
        let (stretch, joint) = self.stretch;
        if stretch > 0.05 * longest {
            let name = &hierarchy.joints[joint].name;
            self.notes
                .push(format!("bones keep their lengths of the first frame, but '{name}' moves by {stretch:.2} units"));
        }
    }

    /// Returns whether angles cannot be degrees: none is above 2 pi, although the body travels by more than a leg.
    fn shows_radians(&self, hierarchy: &Hierarchy) -> bool {
        if !(0.1..=6.3).contains(&self.largest_angle) {
            return false;
        }
        let names: Vec<String> = hierarchy.joints.iter().map(|joint| joint.name.clone()).collect();
        let parents: Vec<Option<usize>> = hierarchy.joints.iter().map(|joint| joint.parent).collect();
        let tree = Tree { names: &names, parents: &parents, offsets: &self.offsets };
        let Some([[_, shank, foot], _]) = roles::find(tree, &BTreeMap::new()).legs() else { return false };
        let leg = self.offsets[shank].norm() + self.offsets[foot].norm();
        let travel = self.root_position.iter().map(|place| (place - self.root_position[0]).norm()).fold(0.0, f64::max);
        travel > leg
    }
}

/// Merges the joints above the root, and changes unit, axes and rest pose.
fn assemble(
    file: &Path,
    options: &ReadOptions,
    hierarchy: &Hierarchy,
    convention: Convention,
    fps: f64,
    motion: Motion,
    mut notes: Vec<String>,
) -> Result<SourceClip, MotionError> {
    let root = hierarchy.root;
    let body = root..hierarchy.end;
    let offsets = motion.offsets[body.clone()].to_vec();
    let joints = &hierarchy.joints[body.clone()];
    let parents: Vec<Option<usize>> =
        joints.iter().enumerate().map(|(at, j)| j.parent.filter(|_| at > 0).map(|p| p - root)).collect();
    let ends: Vec<(usize, Vec3)> =
        hierarchy.ends.iter().filter(|(j, _)| body.contains(j)).map(|(j, o)| (j - root, *o)).collect();
    let known = convention.known(joints);
    let mut raw = RawClip {
        name: clip_name(file),
        provenance: convention.provenance().to_owned(),
        fps,
        cyclic: false,
        names: joints.iter().map(|j| j.name.clone()).collect(),
        known,
        parents,
        offsets,
        ends,
        hints: convention.hints(joints),
        root_position: motion.root_position,
        rotations: motion.rotations,
        notes: Vec::new(),
    };
    let scale = match options.scale {
        Some(scale) if scale.is_finite() && scale > 0.0 => scale,
        Some(scale) => {
            return Err(MotionError::format(file.display(), "a positive number of metres per unit (--scale)", scale));
        }
        None => unit::guess(file, &raw, &mut notes)?,
    };
    let places = raw.offsets.iter_mut().chain(raw.ends.iter_mut().map(|(_, o)| o)).chain(raw.root_position.iter_mut());
    places.for_each(|v| *v *= scale);
    raw.notes = notes;
    raw.finish(options)
}
