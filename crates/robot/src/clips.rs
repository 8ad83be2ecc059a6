//! Clips of a robot from any kind of name: motion of the robot, captured motion, or our keyframed clips.
//!
//! Files of a data set differ in quality. A clip that cannot be used is skipped with its reason
//! ([`LoadedClips::left_out`]) and the others are loaded. [`LoadedClips::all`] fails instead.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use lifelike_motion::edit::mirror;
use lifelike_motion::formats::robot_motion::{self, Layout};
use lifelike_motion::formats::{self, FileMotion, ReadOptions};
use lifelike_motion::lint::MIN_FPS;
use lifelike_motion::retarget::{RetargetOptions, retarget};
use lifelike_motion::{MotionClip, MotionError, SourceClip, dataset, keyframes};
use rayon::prelude::*;

use crate::nearest::hint;
use crate::robot::Robot;
use crate::{FromInput, RobotError};

/// Share of an actuator's largest speed that a retargeted joint may have, so that the policy has room to correct.
pub const SPEED_SHARE: f64 = 0.8;

/// Frames at the policy's rate below which a clip has no velocities to follow.
const MIN_FRAMES: f64 = 3.0;

/// Reasons that one message lists; a folder of another robot's clips has thousands.
const MAX_LISTED: usize = 10;

/// Clips of a robot, and the files that gave none.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LoadedClips {
    /// The clips.
    pub clips: Vec<MotionClip>,
    /// File of each clip.
    pub files: Vec<PathBuf>,
    /// Files that were left out, sorted.
    pub left_out: Vec<LeftOut>,
}

/// A file that was left out.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct LeftOut {
    /// The file.
    pub file: PathBuf,
    /// The reason, which names the file.
    pub reason: String,
}

impl LoadedClips {
    /// Returns the clips when nothing was left out.
    ///
    /// # Errors
    /// [`RobotError::Clips`] with the reasons when something was.
    pub fn all(self) -> Result<Vec<MotionClip>, RobotError> {
        if self.left_out.is_empty() {
            Ok(self.clips)
        } else {
            Err(RobotError::Clips { reasons: reasons(&self.left_out) })
        }
    }

    /// Sorts by name, and leaves out all clips of one name but the first by file.
    fn with_names_of_their_own(mut self) -> Self {
        let mut by_name: BTreeMap<String, (MotionClip, PathBuf)> = BTreeMap::new();
        for (clip, file) in self.clips.drain(..).zip(self.files.drain(..)) {
            if let Some((_, first)) = by_name.get(&clip.name) {
                let (file_text, first) = (file.display(), first.display());
                let reason = format!("{file_text}: a clip named '{}' is already loaded from {first}", clip.name);
                self.left_out.push(LeftOut { file, reason });
            } else {
                by_name.insert(clip.name.clone(), (clip, file));
            }
        }
        (self.clips, self.files) = by_name.into_values().unzip();
        self.left_out.sort_by(|a, b| a.file.cmp(&b.file));
        self
    }
}

/// The input that stands for our own basic clips; `builtin:NAME` stands for one of all that we have.
const BUILTIN: &str = "builtin";
/// The input that stands for all of our own clips.
const ALL: &str = "builtin:all";

/// Loads clips from files, folders, patterns, `@list.txt` and our own ones (`builtin`, `builtin:all`, `builtin:NAME`) ([`dataset::find_files`]), sorted by name, each name once:
/// of two files with one name the first by path is kept. Motion of robots is taken as it is; human motion is retargeted
/// on the way, at the policy's rate and within the actuators' speeds.
///
/// # Errors
/// As [`load_files`].
pub fn load(inputs: &[PathBuf], robot: &Robot) -> Result<LoadedClips, RobotError> {
    load_as(inputs, None, robot)
}

/// Loads clips as [`load`] does; motion of robots has this layout, or the one that is found.
///
/// # Errors
/// As [`load_files`].
pub fn load_as(inputs: &[PathBuf], layout: Option<&'static Layout>, robot: &Robot) -> Result<LoadedClips, RobotError> {
    Ok(load_files(inputs, layout, robot)?.with_names_of_their_own())
}

/// Loads clips as [`load_as`] does, but sorted by file, and names may repeat.
///
/// # Errors
/// [`RobotError::Motion`] for an input that is not there or holds no motion. [`RobotError::Clips`] with the reasons
/// when no file is of use, as when a single file was named and is none.
pub fn load_files(
    inputs: &[PathBuf],
    layout: Option<&'static Layout>,
    robot: &Robot,
) -> Result<LoadedClips, RobotError> {
    let (words, paths): (Vec<PathBuf>, Vec<PathBuf>) =
        dataset::with_lists(inputs)?.into_iter().partition(|input| is_builtin(input));
    let own = builtin_by(&words, robot)?;
    let files = if paths.is_empty() { Vec::new() } else { dataset::find_motion(&paths, |_| true)? };
    let options = speed_limited(robot);
    let reading = ReadOptions { robot: Some(robot.character.clone()), layout, ..ReadOptions::default() };
    let read = |file: &PathBuf| {
        let clip = match formats::read(file, &reading)? {
            FileMotion::Robot(clip) => {
                if formats::of_file(file).is_some_and(|format| format.name == robot_motion::FORMAT.name) {
                    tracing::info!("{}", clip.provenance.source);
                }
                clip
            }
            FileMotion::Source(source) => retargeted(&source, robot, &options)?,
        };
        usable(&clip, robot)?;
        Ok(clip)
    };
    let read: Vec<Result<MotionClip, MotionError>> = files.par_iter().map(read).collect();
    let mut loaded = gathered(files, read);
    loaded.clips.splice(0..0, own.clips);
    loaded.files.splice(0..0, own.files);
    loaded.left_out.splice(0..0, own.left_out);
    if loaded.clips.is_empty() {
        return Err(RobotError::Clips { reasons: reasons(&loaded.left_out) });
    }
    Ok(loaded)
}

/// Loads the one clip of an input.
///
/// # Errors
/// As [`load_files`] and [`LoadedClips::all`], and when it is not exactly one.
pub fn load_one(input: &Path, robot: &Robot) -> Result<MotionClip, RobotError> {
    load_one_as(input, None, robot)
}

/// Loads the one clip of an input as [`load_as`] does.
///
/// # Errors
/// As [`load_one`].
pub fn load_one_as(input: &Path, layout: Option<&'static Layout>, robot: &Robot) -> Result<MotionClip, RobotError> {
    let clips = load_as(&[input.to_path_buf()], layout, robot)?.all()?;
    <[MotionClip; 1]>::try_from(clips)
        .map(|[clip]| clip)
        .map_err(|clips| RobotError::mismatch(input.display(), "one clip", clips.len()))
}

/// Returns our own basic clips ([`keyframes::BASIC`]) on a robot. Clips that do not suit it are left out.
pub fn builtin(robot: &Robot) -> LoadedClips {
    builtin_where(robot, is_basic)
}

/// Returns true for the `builtin:NAME` of a basic clip.
fn is_basic(file: &Path) -> bool {
    file.to_str().and_then(|text| text.split_once(':')).is_some_and(|(_, name)| keyframes::BASIC.contains(&name))
}

/// Our own clips whose `builtin:NAME` is wanted; only those are retargeted.
fn builtin_where(robot: &Robot, wanted: impl Fn(&Path) -> bool) -> LoadedClips {
    let options = speed_limited(robot);
    let (files, texts): (Vec<PathBuf>, Vec<(&str, &str)>) = keyframes::builtin()
        .map(|(name, text)| (PathBuf::from(format!("{BUILTIN}:{name}")), (name, text)))
        .filter(|(file, _)| wanted(file))
        .unzip();
    let make = |(name, text): &(&str, &str)| {
        let source = keyframes::parse(text.as_bytes(), Path::new(name))?;
        retargeted(&source, robot, &options)
    };
    let made: Vec<Result<MotionClip, MotionError>> = texts.par_iter().map(make).collect();
    gathered(files, made)
}

/// Returns true for an input that is our own clips (`builtin`) or one of them (`builtin:walk`) rather than a path.
pub fn is_builtin(input: &Path) -> bool {
    input
        .to_str()
        .is_some_and(|text| text.strip_prefix(BUILTIN).is_some_and(|rest| rest.is_empty() || rest.starts_with(':')))
}

/// Our own clips that these words name.
fn builtin_by(words: &[PathBuf], robot: &Robot) -> Result<LoadedClips, RobotError> {
    if words.is_empty() {
        return Ok(LoadedClips::default());
    }
    let names: Vec<PathBuf> =
        keyframes::builtin().map(|(name, _)| PathBuf::from(format!("{BUILTIN}:{name}"))).collect();
    let is = |set: &str| words.iter().any(|word| word.as_os_str() == set);
    if let Some(unknown) =
        words.iter().find(|word| word.as_os_str() != BUILTIN && word.as_os_str() != ALL && !names.contains(word))
    {
        let (names, got) = (names.iter().filter_map(|name| name.to_str()), unknown.display().to_string());
        let near = hint(&got, names.clone().chain([ALL]));
        return Err(RobotError::mismatch("our own clips", names.collect::<Vec<_>>().join(", "), got + &near));
    }
    let (basic, all) = (is(BUILTIN), is(ALL));
    Ok(builtin_where(robot, |file| all || basic && is_basic(file) || words.iter().any(|word| word == file)))
}

/// End of the name of a mirror image.
pub const MIRRORED: &str = "+mirror";

/// Returns these clips, and after them the mirror image of each by the robot's own symmetry, called `NAME+mirror`.
///
/// # Errors
/// A robot that is not symmetric; a clip of another robot.
pub fn with_mirror_images(mut clips: Vec<MotionClip>, robot: &Robot) -> Result<Vec<MotionClip>, MotionError> {
    let image = |clip: &MotionClip| {
        let name = format!("{}{MIRRORED}", clip.name);
        Ok(MotionClip { name, ..mirror(clip, &robot.character)? })
    };
    let images: Result<Vec<_>, MotionError> = clips.iter().map(image).collect();
    clips.extend(images?);
    Ok(clips)
}

/// Returns the options of retargeting where nothing else is said: at the policy's rate.
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

/// Lists what was left out, a line each, up to a number that a person reads.
pub fn reasons(left_out: &[LeftOut]) -> String {
    let mut lines: Vec<String> = left_out.iter().take(MAX_LISTED).map(|left| left.reason.clone()).collect();
    if left_out.len() > MAX_LISTED {
        lines.push(format!("and {} more", left_out.len() - MAX_LISTED));
    }
    lines.join("\n  ")
}

fn speed_limited(robot: &Robot) -> RetargetOptions {
    let mut options = retarget_options(robot);
    limit_speeds(&mut options, robot);
    options
}

fn retargeted(source: &SourceClip, robot: &Robot, options: &RetargetOptions) -> Result<MotionClip, MotionError> {
    Ok(retarget(source, &robot.character, &robot.anatomy, options)?.0)
}

/// Checks that a clip is of this robot, has a rate that is one, and is long enough to be followed.
fn usable(clip: &MotionClip, robot: &Robot) -> Result<(), MotionError> {
    clip.columns_for(&robot.character)?;
    if clip.fps < MIN_FPS {
        let message = format!(
            "expected at least {MIN_FPS} frame per second, got {}: a frame time? `lifelike motion lint FILE --fix -o FOLDER` \
             makes it {:.3} frames per second",
            clip.fps,
            1.0 / clip.fps
        );
        return Err(MotionError::Unfit { clip: clip.name.clone(), message });
    }
    let frames = (clip.seconds() * robot.control_hz + 1e-6).floor() + 1.0;
    if frames < MIN_FRAMES {
        let message = format!("expected at least {MIN_FRAMES} frames at the policy's rate, got {frames}");
        return Err(MotionError::Unfit { clip: clip.name.clone(), message });
    }
    Ok(())
}

fn gathered(files: Vec<PathBuf>, read: Vec<Result<MotionClip, MotionError>>) -> LoadedClips {
    let mut loaded = LoadedClips::default();
    for (file, read) in files.into_iter().zip(read) {
        match read {
            Ok(clip) => {
                loaded.clips.push(clip);
                loaded.files.push(file);
            }
            Err(error) => {
                let (path, reason) = (file.display().to_string(), error.to_string());
                // What is wrong inside of a file names it already.
                let reason = if reason.contains(&path) { reason } else { format!("{path}: {reason}") };
                loaded.left_out.push(LeftOut { file, reason });
            }
        }
    }
    loaded
}
