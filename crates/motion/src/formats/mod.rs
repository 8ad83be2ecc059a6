//! Readers: from captured files to [`SourceClip`].
//!
//! | format | files | axes and unit in the file | rest pose in the file |
//! | --- | --- | --- | --- |
//! | [`bvh`] | Daz-friendly CMU | y up, z forward, cm | T-pose, forearms drawn bent by 17 degrees; frames 0 to 6 are skipped |
//! | | Bandai-Namco | y up, z forward, cm | none (zero rotations lay bones along x): a table of joint frames |
//! | | any other | from names and geometry | zero rotations |
//! | [`asf`], [`amc`] | CMU originals | y up, z forward, inches / 0.45 | T-pose, legs spread by 20 degrees |
//! | [`deepmimic`] | humanoid3d | y up, x forward, z right, m | standing, arms hanging |
//!
//! What comes out is always z up, x forward, y left, in metres, and (unless [`ReadOptions::t_pose`] is off, or the limbs'
//! names are unknown) with the SAME rest pose: a T-pose, legs straight down, feet forward and flat, arms straight to the
//! sides with palms down. Only the world position and heading at which a clip starts stay as they were captured.

use std::path::{Path, PathBuf};

use crate::error::MotionError;
use crate::source::SourceClip;

pub mod amc;
pub mod asf;
pub mod bvh;
pub mod captions;
pub mod deepmimic;
mod raw;
mod rest;
mod text;

pub(crate) use text::decode;

pub use captions::CaptionTable;

/// How to read a file. The default guesses all of it.
#[derive(Debug, Clone)]
pub struct ReadOptions {
    /// Metres per unit of length of a BVH file. `None`: guessed from the skeleton's size among m, cm and mm (a body of
    /// 1 to 2.5 m); inches must be stated. The other formats say or fix their unit.
    pub scale: Option<f64>,
    /// Frames to leave out at the start of a BVH file. `None`: seven for the Daz-friendly skeleton (frame 0 is a rest pose,
    /// and the conversion's filter smeared it over the six that follow), none for the others.
    pub skip_frames: Option<usize>,
    /// Frames per second of an AMC file, which does not say (CMU: 120 but for a few at 60).
    pub amc_fps: f64,
    /// The skeleton that goes with the motion: the ASF of an AMC, the character file of a DeepMimic clip. `None`: found
    /// beside the motion (`SS.asf` for `SS_TT.amc`, or the only ASF there; `humanoid3d.txt`).
    pub skeleton: Option<PathBuf>,
    /// Bring the rest pose to the T-pose (see the module's documentation).
    pub t_pose: bool,
    /// What people said about the clips, found by the file's name.
    pub captions: Option<CaptionTable>,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self { scale: None, skip_frames: None, amc_fps: 120.0, skeleton: None, t_pose: true, captions: None }
    }
}

/// Reads a captured clip. The format is known by the extension (`bvh`, `amc`) or the content (DeepMimic's JSON).
///
/// # Errors
/// [`MotionError::Io`] for a file that cannot be read, [`MotionError::Parse`] with the line for content that is not the
/// format's, [`MotionError::Container`] where no line is to blame (an unknown format, no skeleton beside the motion).
pub fn read(path: &Path, options: &ReadOptions) -> Result<SourceClip, MotionError> {
    let bytes = text::read_bytes(path)?;
    let mut clip = match format_of(path, &bytes) {
        Some(Format::Bvh) => bvh::parse(&bytes, path, options),
        Some(Format::Amc) => {
            let asf = match &options.skeleton {
                Some(asf) => asf.clone(),
                None => amc::skeleton_beside(path)?,
            };
            let skeleton = asf::parse(&text::read_bytes(&asf)?, &asf)?;
            amc::parse(&bytes, path, &skeleton, options)
        }
        Some(Format::DeepMimic) => {
            let character = match &options.skeleton {
                Some(character) => character.clone(),
                None => deepmimic::character_beside(path)?,
            };
            let character = deepmimic::parse_character(&text::read_bytes(&character)?, &character)?;
            deepmimic::parse(&bytes, path, &character, options)
        }
        None => Err(MotionError::Container {
            file: path.to_path_buf(),
            expected: "motion as BVH (.bvh), ASF/AMC (.amc) or DeepMimic JSON".to_owned(),
            got: "something else".to_owned(),
        }),
    }?;
    if let Some(table) = &options.captions {
        clip.captions = table.find(path, clip.seconds());
    }
    Ok(clip)
}

enum Format {
    Bvh,
    Amc,
    DeepMimic,
}

/// The extension decides; content does where the extension says nothing.
fn format_of(path: &Path, bytes: &[u8]) -> Option<Format> {
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    match extension.as_deref() {
        Some("bvh") => return Some(Format::Bvh),
        Some("amc") => return Some(Format::Amc),
        _ => {}
    }
    let start = bytes.iter().position(|b| !b.is_ascii_whitespace()).map_or(bytes, |at| &bytes[at..]);
    if start.starts_with(b"HIERARCHY") {
        Some(Format::Bvh)
    } else if start.starts_with(b"#!OML:ASF") {
        Some(Format::Amc)
    } else if start.starts_with(b"{") {
        Some(Format::DeepMimic)
    } else {
        None
    }
}

/// The clip's name: the file's, without extension.
fn name_of(path: &Path) -> String {
    path.file_stem().map_or_else(|| "clip".to_owned(), |stem| stem.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests;
