//! Clips of a robot for a command: as the library loads them, and what was left out is told on standard error.

use std::path::PathBuf;

use lifelike_motion::MotionClip;
use lifelike_robot::{Robot, clips};

use crate::error::CliError;

pub use lifelike_robot::clips::with_mirror_images;
pub use lifelike_robot::clips::{limit_speeds, load_one, retarget_options};

/// Loads clips by [`clips::load`].
///
/// # Errors
/// As [`clips::load`].
pub fn load(inputs: &[PathBuf], robot: &Robot) -> Result<Vec<MotionClip>, CliError> {
    let loaded = clips::load(inputs, robot)?;
    warn_of(&loaded.left_out);
    Ok(loaded.clips)
}

/// Loads clips with their files by [`clips::load_files`].
///
/// # Errors
/// As [`clips::load_files`].
pub fn load_files(inputs: &[PathBuf], robot: &Robot) -> Result<Vec<(PathBuf, MotionClip)>, CliError> {
    let loaded = clips::load_files(inputs, robot)?;
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
