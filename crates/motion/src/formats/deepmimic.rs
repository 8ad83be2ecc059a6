//! DeepMimic's motions (Peng et al. 2018) of its `humanoid3d` character: JSON with one row of numbers per frame.
//!
//! A row is the frame's duration (s), the root's position (m) and orientation (`wxyz`), then numbers per joint in the
//! order of the character file. These are a quaternion (spherical) or an angle about the z axis (revolute). The file's
//! axes are y up, x forward, z right. A vector becomes `(x, -z, y)`, a quaternion `(w, x, -z, y)`, and a hinge turns
//! about our `-y`. A motion that wraps ends with its first pose again: its last frame is one whole cycle after the
//! first.

use std::path::{Path, PathBuf};

use lifelike_character::{Quat, Vec3, rotation};

use super::raw::{self, RawClip};
use super::standing::Known;
use super::{Format, ReadOptions, Reader, clip_name, rest, text};
use crate::source::SourceClip;
use crate::{FromInput, MotionError};

/// The format, for the table of all.
pub const FORMAT: Format = Format {
    name: "DeepMimic",
    suffixes: &[],
    shared_suffixes: &[".txt", ".json"],
    companion: "humanoid3d.txt",
    not_motion: &[],
    clip_name: |_| None,
    // Notes end in .txt too, and a character file is such JSON without frames.
    sniff: |sample| sample.start.starts_with(b"{") && sample.start.windows(8).any(|w| w == b"\"Frames\""),
    reader: Reader::Source(read),
};

/// More joints than a DeepMimic character has (`humanoid3d`: 15).
const MOST_JOINTS: usize = 128;
/// No frame of a motion lasts longer (s); so a few rows cannot stand for hours.
const LONGEST_FRAME: f64 = 1.0;

/// Kind of motion of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointType {
    /// The root, which is free.
    Free,
    /// Four numbers: a quaternion.
    Spherical,
    /// One number: an angle about z.
    Revolute,
    /// None.
    Fixed,
}

/// A joint of a character file.
#[derive(Debug, Clone, PartialEq)]
pub struct CharacterJoint {
    /// Its name.
    pub name: String,
    /// The joint it hangs on.
    pub parent: Option<usize>,
    /// From the parent (m, the file's axes).
    pub offset: Vec3,
    /// Kind of motion.
    pub kind: JointType,
}

#[derive(serde::Deserialize)]
struct CharacterFile {
    #[serde(rename = "Skeleton")]
    skeleton: SkeletonSection,
}

#[derive(serde::Deserialize)]
struct SkeletonSection {
    #[serde(rename = "Joints")]
    joints: Vec<JointEntry>,
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "PascalCase")]
struct JointEntry {
    name: String,
    r#type: String,
    parent: i64,
    attach_x: f64,
    attach_y: f64,
    attach_z: f64,
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "PascalCase")]
struct MotionFile {
    r#loop: String,
    frames: Vec<Vec<f64>>,
}

/// Reads a motion with its character, which the options name or which lies beside it.
fn read(bytes: &[u8], file: &Path, options: &ReadOptions) -> Result<SourceClip, MotionError> {
    let character = match &options.skeleton {
        Some(character) => character.clone(),
        None => character_beside(file)?,
    };
    let character = parse_character(&text::read_bytes(&character)?, &character)?;
    parse(bytes, file, &character, options)
}

/// Returns the character file beside a motion: `humanoid3d.txt`.
///
/// # Errors
/// [`MotionError::Input`] when there is none.
pub fn character_beside(motion: &Path) -> Result<PathBuf, MotionError> {
    let character = motion.with_file_name("humanoid3d.txt");
    if character.is_file() && character != motion {
        return Ok(character);
    }
    Err(MotionError::format(motion.display(), "its character humanoid3d.txt beside it", "none"))
}

/// Reads the skeleton of a character file.
///
/// # Errors
/// [`MotionError::Parse`] with the line for broken JSON, [`MotionError::Input`] for a tree that makes no sense.
pub fn parse_character(bytes: &[u8], file: &Path) -> Result<Vec<CharacterJoint>, MotionError> {
    let content = text::decode(bytes, file)?;
    let parsed: CharacterFile =
        serde_json::from_str(content).map_err(|e| json_error(file, "a DeepMimic character", &e))?;
    let entries = parsed.skeleton.joints;
    let wrong = |expected: &str, got: String| MotionError::format(file.display(), expected, got);
    if entries.is_empty() || entries.len() > MOST_JOINTS {
        return Err(wrong("1 to 128 joints", entries.len().to_string()));
    }
    let mut joints: Vec<CharacterJoint> = Vec::with_capacity(entries.len());
    for (at, entry) in entries.into_iter().enumerate() {
        let parent = usize::try_from(entry.parent).ok();
        if parent.is_some_and(|p| p >= at) || (parent.is_none() != (at == 0)) {
            return Err(wrong("parents before children, and one root first", format!("joint '{}'", entry.name)));
        }
        let kind = match (at, entry.r#type.as_str()) {
            (0, _) => JointType::Free,
            (_, "spherical") => JointType::Spherical,
            (_, "revolute") => JointType::Revolute,
            (_, "fixed") => JointType::Fixed,
            (_, other) => return Err(wrong("a joint that is spherical, revolute or fixed", format!("'{other}'"))),
        };
        let offset = Vec3::new(entry.attach_x, entry.attach_y, entry.attach_z);
        if offset.amax() > 100.0 {
            return Err(wrong("joints within 100 m", format!("joint '{}' at {offset:?}", entry.name)));
        }
        joints.push(CharacterJoint { name: entry.name, parent, offset, kind });
    }
    Ok(joints)
}

/// Reads a motion of that character. `file` is for names and messages only. Frames of unequal duration are resampled at
/// the first frame's (linearly, rotations by slerp).
///
/// # Errors
/// [`MotionError::Parse`] with the line for broken JSON, [`MotionError::Input`] with the frame for wrong numbers.
pub fn parse(
    bytes: &[u8],
    file: &Path,
    character: &[CharacterJoint],
    options: &ReadOptions,
) -> Result<SourceClip, MotionError> {
    let content = text::decode(bytes, file)?;
    let motion: MotionFile = serde_json::from_str(content).map_err(|e| json_error(file, "a DeepMimic motion", &e))?;
    let wrong = |expected: String, got: String| MotionError::format(file.display(), expected, got);

    let width: usize = 1 + character.iter().map(|j| numbers_of(j.kind)).sum::<usize>();
    let (mut times, mut time) = (Vec::new(), 0.0);
    let (mut root_position, mut rotations) = (Vec::new(), Vec::new());
    for (at, row) in motion.frames.iter().enumerate() {
        if row.len() != width {
            return Err(wrong(format!("{width} numbers in frame {at}"), row.len().to_string()));
        }
        if let Some(value) = row.iter().find(|v| v.abs() > 1e6) {
            return Err(wrong(format!("numbers below a million in frame {at}"), value.to_string()));
        }
        let last = at + 1 == motion.frames.len();
        if !last && !(1e-5..=LONGEST_FRAME).contains(&row[0]) {
            return Err(wrong(format!("a duration up to {LONGEST_FRAME} s of frame {at}"), row[0].to_string()));
        }
        let frame = joint_rotations(character, row).ok_or_else(|| {
            wrong(format!("quaternions of a rotation in frame {at}"), "one without direction".to_owned())
        })?;
        times.push(time);
        time += row[0];
        root_position.push(Vec3::new(row[1], row[2], row[3]));
        rotations.push(frame);
    }
    let Some(step) = motion.frames.first().map(|row| row[0]).filter(|_| times.len() > 1) else {
        return Err(wrong("at least two frames".to_owned(), times.len().to_string()));
    };
    let uneven = times.windows(2).any(|pair| (pair[1] - pair[0] - step).abs() > 0.02 * step);
    if uneven {
        // Few rows must not stand for a huge motion.
        if times[times.len() - 1] / step > 16.0 * times.len() as f64 {
            return Err(wrong(
                "frames about as long as the first".to_owned(),
                format!("{step} s, and far longer ones"),
            ));
        }
        (root_position, rotations) = resampled(&times, step, &root_position, &rotations);
    }
    let raw = RawClip {
        name: clip_name(file),
        provenance: "DeepMimic humanoid3d motion (Peng et al. 2018), MIT".to_owned(),
        fps: raw::rate(step),
        cyclic: motion.r#loop == "wrap",
        names: character.iter().map(|j| j.name.clone()).collect(),
        parents: character.iter().map(|j| j.parent).collect(),
        offsets: character.iter().map(|j| j.offset).collect(),
        ends: Vec::new(),
        known: Some(Known {
            basis: raw::about(0, std::f64::consts::FRAC_PI_2),
            rest: vec![Quat::identity(); character.len()],
        }),
        hints: rest::Hints::default(),
        root_position,
        rotations,
        notes: Vec::new(),
    };
    raw.finish(options)
}

fn numbers_of(kind: JointType) -> usize {
    match kind {
        JointType::Free => 7,
        JointType::Spherical => 4,
        JointType::Revolute => 1,
        JointType::Fixed => 0,
    }
}

/// Returns the joints' rotations of a row whose length is right; `None` for a quaternion without direction.
fn joint_rotations(character: &[CharacterJoint], row: &[f64]) -> Option<Vec<Quat>> {
    let mut at = 1;
    let mut rotations = Vec::with_capacity(character.len());
    for joint in character {
        let numbers = &row[at..at + numbers_of(joint.kind)];
        at += numbers.len();
        rotations.push(match (joint.kind, numbers) {
            (JointType::Free, [_, _, _, w, x, y, z]) | (JointType::Spherical, [w, x, y, z]) => {
                rotation::from_wxyz([*w, *x, *y, *z])?
            }
            (JointType::Revolute, [angle]) => raw::about(2, *angle),
            _ => Quat::identity(),
        });
    }
    Some(rotations)
}

/// Returns the frames at even steps. Times rise, and there are at least two.
fn resampled(times: &[f64], step: f64, places: &[Vec3], rotations: &[Vec<Quat>]) -> (Vec<Vec3>, Vec<Vec<Quat>>) {
    let end = times[times.len() - 1];
    let count = (end / step).round().max(1.0) as usize + 1;
    let mut at = 0;
    let mut out = (Vec::new(), Vec::new());
    for frame in 0..count {
        let time = (frame as f64 * step).min(end);
        while at + 2 < times.len() && times[at + 1] <= time {
            at += 1;
        }
        let share = ((time - times[at]) / (times[at + 1] - times[at])).clamp(0.0, 1.0);
        out.0.push(places[at].lerp(&places[at + 1], share));
        let pairs = rotations[at].iter().zip(&rotations[at + 1]);
        out.1.push(pairs.map(|(a, b)| a.try_slerp(b, share, 1e-9).unwrap_or(*a)).collect());
    }
    out
}

fn json_error(file: &Path, expected: &str, error: &serde_json::Error) -> MotionError {
    text::parse_error(file, error.line().max(1), expected, &error.to_string())
}
