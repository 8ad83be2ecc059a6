//! `lifelike motion ...`: motion in, motion out.

pub mod blend;
pub mod check;
pub mod compose;
pub mod convert;
mod direct;
pub mod lint;
pub mod mirror;
pub mod place;
pub mod repair;
pub mod retarget;
pub mod sequence;
pub mod stylize;
pub mod trim;
pub mod warp;

// By networks of the training framework.
pub mod edit;
pub mod interpolate;
pub mod search;

use std::path::{Path, PathBuf};

use clap::Subcommand;
use lifelike_motion::MotionClip;
use lifelike_motion::container::EXTENSION;
use lifelike_motion::dataset;
use lifelike_motion::formats::Format;
use lifelike_robot::clips::is_builtin;
use lifelike_robot::{Robot, load};

use crate::destination;
use crate::error::CliError;
use crate::output::Output;

/// Retarget captured motion to robots, check whether they can execute it, find alike motion, and direct it: new motion from
/// what there is.
#[derive(Debug, Subcommand)]
#[allow(missing_docs)] // a comment on a variant would take the place of the command's help text
pub enum Motion {
    Retarget(retarget::Args),
    Convert(convert::Args),
    Check(check::Args),
    Lint(lint::Args),
    Repair(repair::Args),
    Search(search::Args),
    Interpolate(interpolate::Args),
    Sequence(sequence::Args),
    Compose(compose::Args),
    Blend(blend::Args),
    Warp(warp::Args),
    Place(place::Args),
    Stylize(stylize::Args),
    Mirror(mirror::Args),
    Trim(trim::Args),
    Edit(edit::Args),
}

impl Motion {
    /// Runs it.
    ///
    /// # Errors
    /// As the command.
    pub fn run(self, output: &Output) -> Result<(), CliError> {
        match self {
            Self::Retarget(args) => retarget::run(&args, output),
            Self::Convert(args) => convert::run(&args, output),
            Self::Check(args) => check::run(&args, output),
            Self::Lint(args) => lint::run(&args, output),
            Self::Repair(args) => repair::run(&args, output),
            Self::Search(args) => search::run(&args, output),
            Self::Interpolate(args) => interpolate::run(&args, output),
            Self::Sequence(args) => sequence::run(&args, output),
            Self::Compose(args) => compose::run(&args, output),
            Self::Blend(args) => blend::run(&args, output),
            Self::Warp(args) => warp::run(&args, output),
            Self::Place(args) => place::run(&args, output),
            Self::Stylize(args) => stylize::run(&args, output),
            Self::Mirror(args) => mirror::run(&args, output),
            Self::Trim(args) => trim::run(&args, output),
            Self::Edit(args) => edit::run(&args, output),
        }
    }
}

/// Returns the file of a clip: the one that was asked for, else one of its name in the folder. A clip goes by its file's name.
pub fn file_of(output: &Path, clip: &mut MotionClip) -> Result<PathBuf, CliError> {
    if !destination::is_motion(output) {
        return container_in(output, &clip.name);
    }
    clip.name = clip_name(output);
    Ok(output.to_path_buf())
}

/// Returns the name of the clip in a file.
pub fn clip_name(file: &Path) -> String {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    name.strip_suffix(EXTENSION).unwrap_or(&name).to_string()
}

/// Returns the file of a clip's container.
///
/// # Errors
/// As [`destination::named`].
pub fn container_in(folder: &Path, name: &str) -> Result<PathBuf, CliError> {
    destination::named(folder, name, EXTENSION)
}

/// Returns the Unitree G1 if it was fetched: the robot of most files that name neither robot nor joints.
pub fn fetched_g1() -> Option<Robot> {
    load::fetched("g1")?;
    Robot::load("g1").ok()
}

/// Returns the robot that a clip names, or the G1 if the joints are its, where it comes with the program or was fetched.
pub fn robot_of(clip: &MotionClip) -> Option<Robot> {
    let named = load::NAMES.into_iter().find(|name| *name == clip.provenance.character);
    let robot = named.and_then(|name| Robot::load(name).ok()).or_else(fetched_g1)?;
    clip.columns_for(&robot.character).is_ok().then_some(robot)
}

/// Finds files of motion, for commands that read no others.
///
/// # Errors
/// As [`dataset::find_motion`]; [`CliError::Input`] for the program's own clips, which are not files.
pub(super) fn motion_files(inputs: &[PathBuf], accepts: impl Fn(&Format) -> bool) -> Result<Vec<PathBuf>, CliError> {
    if let Some(own) = inputs.iter().find(|input| is_builtin(input)) {
        return Err(CliError::Input(format!(
            "{}: the program's own clips are not files; `check`, `eval`, `train` and `demo` take them by name",
            own.display()
        )));
    }
    Ok(dataset::find_motion(inputs, accepts)?)
}
