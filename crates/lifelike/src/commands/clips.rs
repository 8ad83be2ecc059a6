//! Clips of a robot for a command: as the library loads them, and what was left out is told on standard error.

use std::path::PathBuf;

use lifelike_motion::MotionClip;
use lifelike_motion::formats::robot_motion::{self, Layout};
use lifelike_robot::{Robot, clips};

use crate::error::CliError;

pub use lifelike_robot::clips::with_mirror_images;
pub use lifelike_robot::clips::{limit_speeds, load_one, load_one_as, retarget_options};

/// Layout of motion from other programs.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct LayoutArgument {
    /// Layout of motion from other programs (see `lifelike motion convert --help`); found where not given.
    #[arg(long, value_name = "LAYOUT", value_parser = robot_motion::by_name)]
    pub layout: Option<&'static Layout>,
}

/// Loads clips by [`clips::load`].
///
/// # Errors
/// As [`clips::load`].
pub fn load(inputs: &[PathBuf], robot: &Robot) -> Result<Vec<MotionClip>, CliError> {
    load_as(inputs, LayoutArgument::default(), robot)
}

/// Loads clips by [`clips::load_as`].
///
/// # Errors
/// As [`clips::load_as`].
pub fn load_as(inputs: &[PathBuf], layout: LayoutArgument, robot: &Robot) -> Result<Vec<MotionClip>, CliError> {
    let loaded = clips::load_as(inputs, layout.layout, robot)?;
    warn_of(&loaded.left_out);
    Ok(loaded.clips)
}

/// Loads clips with their files by [`clips::load_files`].
///
/// # Errors
/// As [`clips::load_files`].
pub fn load_files(
    inputs: &[PathBuf],
    layout: LayoutArgument,
    robot: &Robot,
) -> Result<Vec<(PathBuf, MotionClip)>, CliError> {
    let loaded = clips::load_files(inputs, layout.layout, robot)?;
    warn_of(&loaded.left_out);
    Ok(loaded.files.into_iter().zip(loaded.clips).collect())
}

/// Our own clips on a robot.
pub fn builtin(robot: &Robot) -> Vec<MotionClip> {
    let loaded = clips::builtin(robot);
    warn_of(&loaded.left_out);
    loaded.clips
}

fn warn_of(left_out: &[clips::LeftOut]) {
    if !left_out.is_empty() {
        tracing::warn!("left out {}:\n  {}", left_out.len(), clips::reasons(left_out));
    }
}
