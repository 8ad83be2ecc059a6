//! AMASS (Mahmood et al. 2019): motion capture as poses of SMPL bodies, one `.npz` for each recording.
//!
//! `poses` is one row per frame: a rotation vector (rad) for each joint, of which the first 22 are the body's in SMPL
//! (72 numbers), SMPL-H (156) and SMPL-X (165) alike. Fingers, jaw and eyes are not read, hands are rigid.
//! `root_orient` and `pose_body` (or `global_orient` and `body_pose`) may be in its place. `trans` (or `transl`, m)
//! moves the whole body, and `mocap_framerate` (older files) or `mocap_frame_rate` is in frames per second. The file's
//! world is z up. The frames of the joints are y up and z forward when the body rests, so the root's rotation also
//! stands the body up.
//!
//! The skeleton is SMPL's mean body (`body.rs`), whoever was captured: `betas`, `dmpls` and `gender` are not used, since
//! the shapes that they stand for are licensed apart, and retargeting changes the size anyway. So limbs are off by the
//! difference between the captured person and the mean one, angles are not. The same mean body stands for SMPL-X, whose
//! origin lies elsewhere in the body: its clips are displaced as a whole by a constant. Retargeting finds the ground
//! anew, so of that only the place remains at which a clip starts.

use std::path::Path;

use lifelike_character::{Quat, Vec3};

use super::npz::{self, Archive};
use super::raw::{self, RawClip};
use super::standing::Known;
use super::{Format, ReadOptions, Reader, clip_name, rest};
use crate::error::MotionError;
use crate::source::SourceClip;

pub(super) mod body;
mod names;

pub use names::recording;

/// The format, for the table of all.
pub const FORMAT: Format = Format {
    name: "AMASS",
    suffixes: &[".npz"],
    shared_suffixes: &[],
    companion: "",
    // Beside the motions of a person AMASS keeps the person's shape.
    not_motion: &["shape.npz", "male_stagei.npz", "female_stagei.npz", "neutral_stagei.npz"],
    clip_name: |path| recording(&std::path::absolute(path).ok()?),
    sniff: |sample| npz::is_start(&sample.start) && (sample.entries.is_empty() || npz::has_any(&sample.entries, &OWN)),
    reader: Reader::Source(parse),
};

/// Numbers in a row of `poses`: of the body alone, SMPL's, SMPL-H's and SMPL-X's.
const WIDTHS: [usize; 4] = [66, 72, 156, 165];
/// Names of the root's rotation, of the body's rotations, and of the body's place: AMASS' first, then the SMPL-X code's.
const ROOTS: [&str; 2] = ["root_orient", "global_orient"];
const BODIES: [&str; 2] = ["pose_body", "body_pose"];
const PLACES: [&str; 2] = ["trans", "transl"];
/// Arrays of which each file of a body's motion or shape has one.
const OWN: [&str; 8] = ["poses", "trans", "betas", "root_orient", "pose_body", "global_orient", "body_pose", "transl"];
/// Names of the frame rate, older files first.
const RATES: [&str; 3] = ["mocap_framerate", "mocap_frame_rate", "fps"];
/// An hour at 120 frames per second. A small compressed file cannot stand for a longer motion.
const MOST_FRAMES: usize = 432_000;

/// Reads an AMASS file. `file` is for names and messages only.
///
/// # Errors
/// [`MotionError::Input`] with the array that is missing, or is not as AMASS publishes it.
pub fn parse(bytes: &[u8], file: &Path, options: &ReadOptions) -> Result<SourceClip, MotionError> {
    let mut archive = Archive::open(bytes, file)?;
    check_arrays(&archive)?;
    let fps = frame_rate(&mut archive, options.fps)?;
    let (frames, poses) = poses(&mut archive)?;
    let places = first_of(&archive, PLACES);
    let places = archive.array(places)?;
    if places.shape() != [frames, 3] {
        return Err(places.wrong_shape(&format!("of shape [{frames}, 3], as there are {frames} frames of poses")));
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
        known: Some(Known { basis: Quat::identity(), rest: vec![raw::from_y_up_z_forward(); joints.len()] }),
        hints: rest::Hints::default(),
        // SMPL turns the body about its pelvis, and moves it then: the pelvis' place is never turned.
        root_position: places.chunks_exact(3).map(|v| pelvis + Vec3::from_column_slice(v)).collect(),
        rotations: poses.chunks_exact(3 * joints.len()).map(rotations).collect(),
        notes: Vec::new(),
    };
    raw.finish(options)
}

/// Returns the number of frames and the body's joints as rows of rotation vectors: from `poses`, or from the parts into
/// which SMPL-X' own code, GVHMR and GMR take it, `root_orient` and `pose_body`.
fn poses(archive: &mut Archive<'_>) -> Result<(usize, Vec<f64>), MotionError> {
    let width = 3 * body::JOINTS.len();
    if archive.has("poses") {
        let poses = archive.array("poses")?;
        return match poses.shape() {
            [frames, given] if WIDTHS.contains(given) => {
                check_length(*frames, &poses)?;
                Ok((*frames, poses.rows(width)?))
            }
            [frames, joints, 3] if WIDTHS.contains(&joints.saturating_mul(3)) => {
                check_length(*frames, &poses)?;
                Ok((*frames, poses.rows(width)?))
            }
            _ => {
                Err(poses
                    .wrong_shape("of rotation vectors: [frames, 66], [frames, 72], [frames, 156] or [frames, 165]"))
            }
        };
    }
    let (root, body) = (first_of(archive, ROOTS), first_of(archive, BODIES));
    let root = archive.array(root)?;
    let frames = match root.shape() {
        [frames, 3] | [frames, 1, 3] => *frames,
        _ => return Err(root.wrong_shape("of shape [frames, 3]")),
    };
    check_length(frames, &root)?;
    let root = root.rows(3)?;
    let body = archive.array(body)?;
    // SMPL's has two joints more, which stand for the hands.
    if !matches!(body.shape(), [given, 63 | 69] | [given, 21 | 23, 3] if *given == frames) {
        return Err(body
            .wrong_shape(&format!("of shape [{frames}, {}], as the root's rotation has {frames} frames", width - 3)));
    }
    let body = body.rows(width - 3)?;
    let rows = root.chunks_exact(3).zip(body.chunks_exact(width - 3));
    Ok((frames, rows.flat_map(|(root, body)| root.iter().chain(body).copied()).collect()))
}

/// Returns the first of two names that is there; else the first.
fn first_of(archive: &Archive<'_>, names: [&'static str; 2]) -> &'static str {
    if !archive.has(names[0]) && archive.has(names[1]) { names[1] } else { names[0] }
}

fn check_length(frames: usize, array: &npz::Array<'_, '_, '_>) -> Result<(), MotionError> {
    if (1..=MOST_FRAMES).contains(&frames) {
        return Ok(());
    }
    Err(array.wrong_shape(&format!("of 1 to {MOST_FRAMES} frames")))
}

/// Checks that the arrays of a motion are there, and says what the file is where that can be told.
fn check_arrays(archive: &Archive<'_>) -> Result<(), MotionError> {
    let has = |names: [&str; 2]| names.into_iter().any(|name| archive.has(name));
    let has_poses = archive.has("poses") || (has(ROOTS) && has(BODIES));
    if !has_poses && !has(PLACES) && archive.has("betas") {
        let got = format!("the shape of a person ({}), which AMASS keeps beside the motions", archive.listed());
        return Err(archive.wrong("a motion of AMASS (arrays poses, trans, mocap_framerate)".to_owned(), got));
    }
    if !has_poses {
        let expected =
            "array 'poses' of AMASS (or 'root_orient' and 'pose_body', or 'global_orient' and 'body_pose')".to_owned();
        return Err(archive.wrong(expected, archive.listed()));
    }
    if !has(PLACES) {
        return Err(archive.wrong("array 'trans' of AMASS (or 'transl')".to_owned(), archive.listed()));
    }
    Ok(())
}

/// Returns the frames per second.
fn frame_rate(archive: &mut Archive<'_>, given: Option<f64>) -> Result<f64, MotionError> {
    if let Some(fps) = given {
        return Ok(fps);
    }
    let Some(name) = RATES.into_iter().find(|name| archive.has(name)) else {
        let names = RATES.map(|name| format!("'{name}'")).join(" or ");
        let expected = format!("array {names} (frames per second), as AMASS publishes it, or --fps RATE");
        let got = format!("{}: a file that was processed since says nothing of its rate", archive.listed());
        return Err(archive.wrong(expected, got));
    };
    let array = archive.array(name)?;
    if !matches!(array.shape(), [] | [1]) {
        return Err(array.wrong_shape("of one number (frames per second)"));
    }
    let rate = array.rows(1)?.first().copied().unwrap_or_default();
    if (1.0..=1000.0).contains(&rate) {
        return Ok(rate);
    }
    Err(archive.wrong(format!("1 to 1000 frames per second in array '{name}', or --fps RATE"), rate.to_string()))
}
