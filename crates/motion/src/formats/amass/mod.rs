//! AMASS (Mahmood et al. 2019): motion capture as poses of SMPL bodies, one `.npz` for each recording.
//!
//! `poses` is one row per frame: a rotation vector (rad) for each joint, of which the first 22 are the body's in SMPL (72
//! numbers), SMPL-H (156) and SMPL-X (165) alike; fingers, jaw and eyes are not read, hands are rigid. `trans` (m) moves
//! the whole body, and `mocap_framerate` (older files) or `mocap_frame_rate` is in frames per second. The file's world is
//! z up; the frames of the joints are y up and z forward when the body rests, so the root's rotation also stands the body
//! up.
//!
//! The skeleton is SMPL's mean body (`body.rs`), whoever was captured: `betas`, `dmpls` and `gender` are not used, since
//! the shapes that they stand for are licensed apart, and retargeting changes the size anyway. So limbs are off by the
//! difference between the captured person and the mean one, angles are not. The same mean body stands for SMPL-X, whose
//! origin lies elsewhere in the body: its clips are displaced as a whole by a constant. Retargeting finds the ground
//! anew, so of that only the place remains at which a clip starts.

use std::path::Path;

use lifelike_character::{Quat, Vec3};

use super::raw::{self, RawClip};
use super::{Format, ReadOptions, Reader, clip_name, rest};
use crate::error::MotionError;
use crate::source::SourceClip;

mod body;
mod names;
mod npz;

pub use names::recording;

use npz::Archive;

/// The format, for the table of all.
pub const FORMAT: Format = Format {
    name: "AMASS",
    suffixes: &[".npz"],
    shared_suffixes: &[],
    companion: "",
    // Beside the motions of a person AMASS keeps the person's shape.
    not_motion: &["shape.npz", "male_stagei.npz", "female_stagei.npz", "neutral_stagei.npz"],
    clip_name: |path| recording(&std::path::absolute(path).ok()?),
    sniff: npz::is_start,
    reader: Reader::Source(parse),
};

/// Numbers in a row of `poses`: SMPL's, SMPL-H's and SMPL-X's.
const WIDTHS: [usize; 3] = [72, 156, 165];
/// Names of the frame rate, older files first.
const RATES: [&str; 2] = ["mocap_framerate", "mocap_frame_rate"];
/// An hour at 120 frames per second. A small compressed file cannot stand for a longer motion.
const MOST_FRAMES: usize = 432_000;

/// Reads an AMASS file. `file` is for names and messages only.
///
/// # Errors
/// [`MotionError::Container`] with the array that is missing, or is not as AMASS publishes it.
pub fn parse(bytes: &[u8], file: &Path, options: &ReadOptions) -> Result<SourceClip, MotionError> {
    let mut archive = Archive::open(bytes, file)?;
    check_arrays(&archive)?;
    let fps = frame_rate(&mut archive)?;
    let poses = archive.array("poses")?;
    let frames = match poses.shape() {
        [frames, width] if WIDTHS.contains(width) => *frames,
        _ => return Err(poses.wrong_shape("of shape [frames, 72], [frames, 156] or [frames, 165]")),
    };
    if !(1..=MOST_FRAMES).contains(&frames) {
        return Err(poses.wrong_shape(&format!("of 1 to {MOST_FRAMES} frames")));
    }
    let poses = poses.rows(3 * body::JOINTS.len())?;
    let places = archive.array("trans")?;
    if places.shape() != [frames, 3] {
        return Err(places.wrong_shape(&format!("of shape [{frames}, 3], as 'poses' has {frames} frames")));
    }
    let places = places.rows(3)?;

    let pelvis = Vec3::from(body::PELVIS);
    let rotations = |pose: &[f64]| -> Vec<Quat> {
        pose.chunks_exact(3).map(|v| Quat::from_scaled_axis(Vec3::from_column_slice(v))).collect()
    };
    let joints = &body::JOINTS;
    let raw = RawClip {
        name: clip_name(file),
        provenance: "AMASS (amass.is.tue.mpg.de), non-commercial research only; on SMPL's mean body, without the \
                     person's own shape (betas)"
            .to_owned(),
        fps,
        cyclic: false,
        names: joints.iter().map(|(name, ..)| (*name).to_owned()).collect(),
        parents: joints.iter().map(|(_, parent, _)| *parent).collect(),
        offsets: joints.iter().map(|(.., offset)| Vec3::from(*offset)).collect(),
        ends: body::HANDS.map(|(wrist, offset)| (wrist, Vec3::from(offset))).to_vec(),
        rest: vec![raw::from_y_up_z_forward(); joints.len()],
        hints: rest::Hints::default(),
        basis: Quat::identity(),
        // SMPL turns the body about its pelvis, and moves it then: the pelvis' place is never turned.
        root_position: places.chunks_exact(3).map(|v| pelvis + Vec3::from_column_slice(v)).collect(),
        rotations: poses.chunks_exact(3 * joints.len()).map(rotations).collect(),
    };
    Ok(raw.finish(options.t_pose))
}

/// Checks that the arrays of a motion are there, and says what the file is where that can be told.
fn check_arrays(archive: &Archive<'_>) -> Result<(), MotionError> {
    let has = |name: &str| archive.has(name);
    if !has("poses") && !has("trans") && has("betas") {
        let got = format!("the shape of a person ({}), which AMASS keeps beside the motions", archive.listed());
        return Err(archive.wrong("a motion of AMASS (arrays poses, trans, mocap_framerate)".to_owned(), got));
    }
    for name in ["poses", "trans"] {
        if !has(name) {
            return Err(archive.wrong(format!("array '{name}' of AMASS"), archive.listed()));
        }
    }
    if !RATES.into_iter().any(has) {
        let expected = format!("array '{}' or '{}' (frames per second), as AMASS publishes it", RATES[0], RATES[1]);
        let got = format!("{}: a file that was processed since says nothing of its rate", archive.listed());
        return Err(archive.wrong(expected, got));
    }
    Ok(())
}

/// Returns the frames per second.
fn frame_rate(archive: &mut Archive<'_>) -> Result<f64, MotionError> {
    let name = if archive.has(RATES[0]) { RATES[0] } else { RATES[1] };
    let array = archive.array(name)?;
    if !matches!(array.shape(), [] | [1]) {
        return Err(array.wrong_shape("of one number (frames per second)"));
    }
    let rate = array.rows(1)?.first().copied().unwrap_or_default();
    if (1.0..=1000.0).contains(&rate) {
        return Ok(rate);
    }
    Err(archive.wrong(format!("1 to 1000 frames per second in array '{name}'"), rate.to_string()))
}
