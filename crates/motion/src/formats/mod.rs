//! Readers: from files to [`SourceClip`] (human motion) or [`MotionClip`] (a robot's).
//!
//! [`FORMATS`] is the one list of formats; [`read`] and [`of_found`] are all that callers need. Human motion comes in:
//!
//! | format | files | axes and unit in the file | rest pose in the file |
//! | --- | --- | --- | --- |
//! | [`bvh`] | Daz-friendly CMU | y up, z forward, cm | T-pose, forearms drawn bent by 17 degrees; frames 0 to 6 are skipped |
//! | | Bandai-Namco | y up, z forward, cm | none (zero rotations lay bones along x): a table of joint frames |
//! | | any other | found from the places of joints over time | zero rotations where these stand, else found |
//! | [`fbx`] | any skeleton | the file says both | the bind pose, else found from the motion |
//! | [`asf`], [`amc`] | CMU originals | y up, z forward, inches / 0.45 | T-pose, legs spread by 20 degrees |
//! | [`deepmimic`] | humanoid3d | y up, x forward, z right, m | standing, arms hanging |
//! | [`humanml3d`] | HumanML3D's features or joints (.npy) | y up, z forward, m | none in the file: the mean body's |
//! | [`amass`] | AMASS' .npz (SMPL, SMPL-H, SMPL-X) | z up, m; joints' frames y up, z forward | none in the file: the mean body's |
//!
//! The result is always z up, x forward, y left, in metres. It always has the SAME rest pose, unless
//! [`ReadOptions::t_pose`] is off or limbs are missing. That is a T-pose: legs straight down, feet forward and flat,
//! arms straight to the sides with palms down. Only the initial world position and heading of a clip stay as captured.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_character::Character;

use crate::clip::MotionClip;
use crate::retarget::Correspondence;
use crate::source::SourceClip;
use crate::{FromInput, MotionError};
use crate::{container, keyframes};

pub mod amass;
pub mod amc;
mod anatomy;
pub mod asf;
mod axes;
pub mod bvh;
pub mod captions;
pub mod deepmimic;
pub mod fbx;
mod format;
pub mod humanml3d;
mod npz;
pub(crate) mod raw;
mod rest;
pub mod robot_motion;
mod standing;
mod text;

pub(crate) use rest::Hints;
pub(crate) use standing::Known;
pub(crate) use text::decode;

pub use axes::Axis;
pub use captions::CaptionTable;
pub use format::{Format, Reader, Sample, clip_name, of_file, of_found, supported};

/// Every format that is read, in the order in which contents are tried. A new format is one file with its reader and
/// its `FORMAT`, its `mod` above and its name here. Dispatch, search in folders, messages and help texts follow.
pub const FORMATS: &[&Format] = &[
    &bvh::FORMAT,
    &amc::FORMAT,
    &deepmimic::FORMAT,
    &fbx::FORMAT,
    &robot_motion::FORMAT,
    &humanml3d::FORMAT,
    &amass::FORMAT,
    &keyframes::FORMAT,
    &container::FORMAT,
];

/// Options of reading a file. The default guesses all of it.
#[derive(Debug, Clone)]
pub struct ReadOptions {
    /// Metres per unit of length of a BVH file. `None`: guessed from the skeleton's size among m, cm, mm and the CMU's
    /// unit (a body of 1 to 2.5 m); inches must be stated. The other formats say or fix their unit.
    pub scale: Option<f64>,
    /// Frames to leave out at the start of a BVH file. `None`: seven for the Daz-friendly skeleton (frame 0 is a rest
    /// pose, and the conversion's filter smeared it over the six that follow). For the others a rest pose that the
    /// motion leaves by a jump.
    pub skip_frames: Option<usize>,
    /// Frames per second of the capture. `None`: as the file says; 120 for an AMC file that does not.
    pub fps: Option<f64>,
    /// The skeleton that goes with the motion: the ASF of an AMC, the character file of a DeepMimic clip. `None`: found
    /// beside the motion (`SS.asf` for `SS_TT.amc`, or the only ASF there; `humanoid3d.txt`).
    pub skeleton: Option<PathBuf>,
    /// Bring the rest pose to the T-pose (see the module's documentation).
    pub t_pose: bool,
    /// Axis of the file that is up. `None`: found from rest pose and motion.
    pub up: Option<Axis>,
    /// Axis of the file that the rest pose faces, or the motion at first. `None`: found.
    pub forward: Option<Axis>,
    /// Unit of a BVH file's angles. `None`: degrees, unless the motion shows radians.
    pub angles: Option<Angles>,
    /// Joints of roles that names do not tell.
    pub correspondence: Correspondence,
    /// Captions of the clips, found by the file's name.
    pub captions: Option<CaptionTable>,
    /// Layout of a robot's motion. `None`: found from the content.
    pub layout: Option<&'static robot_motion::Layout>,
    /// Robot of a robot's motion: names of joints that come in its order, and kinematics that tell layouts apart.
    pub robot: Option<Arc<Character>>,
}

/// A unit of angles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Angles {
    /// Degrees.
    Degrees,
    /// Radians.
    Radians,
}

impl std::str::FromStr for Angles {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "degrees" => Ok(Self::Degrees),
            "radians" => Ok(Self::Radians),
            _ => Err(format!("expected degrees or radians, got '{text}'")),
        }
    }
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            scale: None,
            skip_frames: None,
            fps: None,
            skeleton: None,
            t_pose: true,
            up: None,
            forward: None,
            angles: None,
            correspondence: Correspondence::default(),
            captions: None,
            layout: None,
            robot: None,
        }
    }
}

/// Motion as a file holds it.
#[derive(Debug, Clone, PartialEq)]
pub enum FileMotion {
    /// Human motion, captured or written.
    Source(SourceClip),
    /// Motion of a robot.
    Robot(MotionClip),
}

/// Reads any file of motion, whose format is known by its name ([`Format::suffixes`]) or its content.
///
/// # Errors
/// [`MotionError::Input`] for a file that cannot be read, [`MotionError::Parse`] with the line for content that is not
/// the format's. [`MotionError::Input`] if no line is to blame (an unknown format, no skeleton beside the motion).
pub fn read(path: &Path, options: &ReadOptions) -> Result<FileMotion, MotionError> {
    let bytes = text::read_bytes(path)?;
    let Some(format) = format::of_content(path, &bytes) else {
        let start: String = String::from_utf8_lossy(&bytes).trim_start().chars().take(40).collect();
        let got = format!("something else, which begins with {start:?}");
        return Err(MotionError::format(path.display(), format!("motion as {}", supported(|_| true)), got));
    };
    Ok(match format.reader {
        Reader::Robot(read) => FileMotion::Robot(read(&bytes, path, options)?),
        Reader::Source(read) => {
            let mut clip = read(&bytes, path, options)?;
            if let Some(table) = &options.captions {
                clip.captions = table.find(path, clip.seconds());
            }
            FileMotion::Source(clip)
        }
    })
}

/// Reads human motion.
///
/// # Errors
/// As [`read`]; [`MotionError::Input`] for motion of a robot.
pub fn read_source(path: &Path, options: &ReadOptions) -> Result<SourceClip, MotionError> {
    match read(path, options)? {
        FileMotion::Source(clip) => Ok(clip),
        FileMotion::Robot(clip) => Err(MotionError::format(
            path.display(),
            format!("human motion as {}", supported(Format::is_source)),
            format!("motion of robot '{}'", clip.provenance.character),
        )),
    }
}

#[cfg(test)]
mod tests;
