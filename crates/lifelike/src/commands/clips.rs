//! Clips of a robot from whatever names them: its own motion, captured motion, or our keyframed clips.

use std::io::Read;
use std::path::{Path, PathBuf};

use lifelike_motion::edit::mirror;
use lifelike_motion::formats::{self, ReadOptions};
use lifelike_motion::retarget::{RetargetOptions, retarget};
use lifelike_motion::{MotionClip, MotionError, SourceClip, container, dataset, keyframes};
use lifelike_robot::Robot;
use rayon::prelude::*;

use crate::error::CliError;

/// Share of an actuator's largest speed that a retargeted joint may have, so that the policy has room to correct.
const SPEED_SHARE: f64 = 0.8;

/// The input that stands for our own clips.
const BUILTIN: &str = "builtin";

/// Retargeting to a robot where nothing else is said: at its policy's rate.
pub fn retarget_options(robot: &Robot) -> RetargetOptions {
    RetargetOptions { fps: robot.control_hz, ..RetargetOptions::default() }
}

/// Fills in the speeds that the robot's actuators allow, for joints of which nothing is said.
pub fn limit_speeds(options: &mut RetargetOptions, robot: &Robot) {
    for (joint, p) in robot.actuators.joints.iter().zip(&robot.actuators.parameters) {
        if p.velocity_max.is_finite() {
            options.velocity_limit.entry(joint.clone()).or_insert(SPEED_SHARE * p.velocity_max);
        }
    }
}

/// Clips from files, folders and patterns, sorted by name. Motion of robots is taken as it is; captured motion and
/// keyframes are retargeted to the robot on the way. `@list.txt` stands for the lines of a file.
///
/// # Errors
/// Whatever is wrong with the first file that is no use; two clips of one name.
pub fn load(inputs: &[PathBuf], robot: &Robot) -> Result<Vec<MotionClip>, CliError> {
    let mut clips: Vec<MotionClip> = load_files(inputs, robot)?.into_iter().map(|(_, clip)| clip).collect();
    clips.sort_by(|a, b| a.name.cmp(&b.name));
    if let Some(pair) = clips.windows(2).find(|pair| pair[0].name == pair[1].name) {
        return Err(CliError::Input(format!("two files have a clip named '{}'", pair[0].name)));
    }
    Ok(clips)
}

/// These clips, and after them the mirror image of each by the robot's own symmetry, called `NAME+mirror`.
///
/// # Errors
/// A robot that is not symmetric; a clip of another robot.
pub fn with_mirror_images(mut clips: Vec<MotionClip>, robot: &Robot) -> Result<Vec<MotionClip>, MotionError> {
    let image = |clip: &MotionClip| {
        let name = format!("{}+mirror", clip.name);
        Ok(MotionClip { name, ..mirror(clip, &robot.character)? })
    };
    let images: Result<Vec<_>, MotionError> = clips.iter().map(image).collect();
    clips.extend(images?);
    Ok(clips)
}

/// One clip from a file, as [`load`] takes it.
///
/// # Errors
/// As [`load`], and when it is not exactly one.
pub fn load_one(input: &Path, robot: &Robot) -> Result<MotionClip, CliError> {
    let clips = load(&[input.to_path_buf()], robot)?;
    match <[MotionClip; 1]>::try_from(clips) {
        Ok([clip]) => Ok(clip),
        Err(clips) => Err(CliError::Input(format!("{}: expected one clip, got {}", input.display(), clips.len()))),
    }
}

/// The same, each with its file, sorted by file; names may repeat.
///
/// # Errors
/// Whatever is wrong with the first file that is no use.
pub fn load_files(inputs: &[PathBuf], robot: &Robot) -> Result<Vec<(PathBuf, MotionClip)>, CliError> {
    let (own, inputs): (Vec<PathBuf>, Vec<PathBuf>) = inputs.iter().cloned().partition(|input| is_builtin(input));
    let mut clips = own_clips(&own, robot)?;
    if !inputs.is_empty() {
        clips.extend(load_outside(&inputs, robot)?);
    }
    Ok(clips)
}

/// Returns whether an input is our own clips (`builtin`), or one of them (`builtin:walk`), rather than a path.
pub fn is_builtin(input: &Path) -> bool {
    input.to_str().is_some_and(|text| text == BUILTIN || text.starts_with("builtin:"))
}

/// Our own clips by [`is_builtin`]'s words, each with the word that names it.
fn own_clips(words: &[PathBuf], robot: &Robot) -> Result<Vec<(PathBuf, MotionClip)>, CliError> {
    if words.is_empty() {
        return Ok(Vec::new());
    }
    let (clips, refused) = builtin(robot);
    for reason in &refused {
        tracing::warn!("left out: {reason}");
    }
    let word = |clip: &MotionClip| PathBuf::from(format!("{BUILTIN}:{}", clip.name));
    let known = |name: &PathBuf| name.as_path() == Path::new(BUILTIN) || clips.iter().any(|clip| word(clip) == *name);
    if let Some(unknown) = words.iter().find(|name| !known(name)) {
        let names: Vec<&str> = clips.iter().map(|clip| clip.name.as_str()).collect();
        let text = format!("expected {BUILTIN}:NAME with one of {}, got '{}'", names.join(", "), unknown.display());
        return Err(CliError::Input(text));
    }
    let all = words.iter().any(|name| name.as_path() == Path::new(BUILTIN));
    let clips = clips.into_iter().map(|clip| (word(&clip), clip));
    Ok(clips.filter(|(word, _)| all || words.contains(word)).collect())
}

fn load_outside(inputs: &[PathBuf], robot: &Robot) -> Result<Vec<(PathBuf, MotionClip)>, CliError> {
    let files = dataset::find_files(&listed(inputs)?, |path| dataset::is_motion_file(path) || is_captured(path))?;
    let mut options = retarget_options(robot);
    limit_speeds(&mut options, robot);
    let read = |file: PathBuf| {
        if dataset::is_motion_file(&file) {
            let clip = container::read(&file)?;
            return Ok((file, clip));
        }
        let source = read_captured(&file, &ReadOptions::default())?;
        let clip = retarget(&source, &robot.character, &robot.anatomy, &options)?.0;
        Ok((file, clip))
    };
    let clips: Vec<Result<(PathBuf, MotionClip), MotionError>> = files.into_par_iter().map(read).collect();
    Ok(clips.into_iter().collect::<Result<Vec<_>, _>>()?)
}

/// Files of captured motion and keyframes from files, folders and patterns, sorted. `@list.txt` stands for the lines of a file.
///
/// # Errors
/// An input that is not there, or in which nothing is of use.
pub fn captured_files(inputs: &[PathBuf]) -> Result<Vec<PathBuf>, CliError> {
    Ok(dataset::find_files(&listed(inputs)?, is_captured)?)
}

/// Replaces `@file` by the lines of the file that are neither empty nor comments (`#`).
fn listed(inputs: &[PathBuf]) -> Result<Vec<PathBuf>, CliError> {
    let mut all = Vec::with_capacity(inputs.len());
    for input in inputs {
        let Some(file) = input.to_str().and_then(|text| text.strip_prefix('@')).filter(|_| !input.exists()) else {
            all.push(input.clone());
            continue;
        };
        let text = std::fs::read_to_string(file).map_err(|e| CliError::Input(format!("{file}: {e}")))?;
        all.extend(text.lines().map(str::trim).filter(|l| !l.is_empty() && !l.starts_with('#')).map(PathBuf::from));
    }
    Ok(all)
}

/// Our own clips on a robot. Clips that do not suit it are left out, and named with the reason.
pub fn builtin(robot: &Robot) -> (Vec<MotionClip>, Vec<String>) {
    let mut options = retarget_options(robot);
    limit_speeds(&mut options, robot);
    let texts: Vec<(&str, &str)> = keyframes::builtin().collect();
    let make = |(name, text): &(&str, &str)| -> Result<MotionClip, MotionError> {
        let source = keyframes::parse(text.as_bytes(), Path::new(name))?;
        Ok(retarget(&source, &robot.character, &robot.anatomy, &options)?.0)
    };
    let made: Vec<Result<MotionClip, MotionError>> = texts.par_iter().map(make).collect();
    let (mut clips, mut refused) = (Vec::new(), Vec::new());
    for made in made {
        match made {
            Ok(clip) => clips.push(clip),
            Err(error) => refused.push(error.to_string()),
        }
    }
    (clips, refused)
}

/// Whether a file is keyframes as text.
pub fn is_keyframes(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().ends_with(".keys.toml"))
}

/// Reads captured motion, or keyframes as if they had been captured.
pub fn read_captured(path: &Path, options: &ReadOptions) -> Result<SourceClip, MotionError> {
    if is_keyframes(path) { keyframes::load(path) } else { formats::read(path, options) }
}

/// Whether a file of a folder looks like captured motion. Text files are looked into: notes and DeepMimic's character
/// files end in `.txt` like its motions.
pub fn is_captured(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    match extension.as_deref() {
        Some("bvh" | "amc") => true,
        Some("toml") => is_keyframes(path),
        Some("txt" | "json") => {
            let mut start = Vec::new();
            let read = std::fs::File::open(path).and_then(|f| f.take(4096).read_to_end(&mut start));
            read.is_ok() && start.windows(8).any(|w| w == b"\"Frames\"")
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn text_is_motion_only_when_it_says_so() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, text: &str| {
            std::fs::write(folder.path().join(name), text).unwrap();
            is_captured(&folder.path().join(name))
        };
        assert!(file("a.txt", "{\"Loop\": \"wrap\",\n\"Frames\": []}"));
        assert!(!file("character.txt", "{\"Skeleton\": {}}"));
        assert!(!file("LICENSE", "MIT"));
        assert!(file("b.BVH", ""));
        assert!(file("c.keys.toml", "") && !file("plan.toml", ""));
    }

    #[test]
    fn a_list_stands_for_its_lines() {
        let folder = tempfile::tempdir().unwrap();
        let list = folder.path().join("list.txt");
        std::fs::write(&list, "# two\na.bvh\n\n  b/*.bvh\n").unwrap();
        let inputs = ["x".into(), PathBuf::from(format!("@{}", list.display()))];
        assert_eq!(listed(&inputs).unwrap(), ["x", "a.bvh", "b/*.bvh"].map(PathBuf::from));
        assert!(listed(&["@none".into()]).unwrap_err().to_string().contains("none"));
    }

    #[test]
    fn our_own_clips_suit_our_own_robots() {
        for name in lifelike_robot::load::NAMES {
            let robot = Robot::load(name).unwrap();
            let (clips, refused) = builtin(&robot);
            assert!(refused.is_empty(), "{name}: {refused:?}");
            assert!(clips.len() >= 12, "{name}: {}", clips.len());
            let slow = clips.iter().all(|c| {
                let n = c.joint_names.len();
                let limits = robot.actuators.parameters.iter().map(|p| SPEED_SHARE * p.velocity_max);
                limits.enumerate().all(|(j, limit)| {
                    let column = c.joints.iter().skip(j).step_by(n).collect::<Vec<_>>();
                    column.windows(2).all(|w| (w[1] - w[0]).abs() * c.fps <= limit * (1.0 + 1e-9))
                })
            });
            assert!(slow, "{name}: no joint is faster than its actuator lets the policy correct");
        }
    }
}
