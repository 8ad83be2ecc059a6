//! `lifelike motion mirror`: what the left side did, the right side does.

use std::path::PathBuf;

use lifelike_motion::edit;

use super::direct::Common;
use crate::error::CliError;
use crate::output::Output;

/// Mirror motion: what the left side did, the right side does, and turns go the other way.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike motion mirror builtin:wave -o data/directed --name wave_left
  lifelike motion mirror data/lima -o data/lima-mirrored   # twice as much to learn from

The symmetry is derived from the robot itself; a robot that has none is refused with the reason.
Results are called NAME-mirrored where no --name is given.")]
pub struct Args {
    /// Clips: files, folders of them, or patterns; anything but *.motion.safetensors is retargeted first.
    #[arg(required = true)]
    pub inputs: Vec<PathBuf>,
    /// Folder, name and robot of the result.
    #[command(flatten)]
    pub common: Common,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    args.common.each(&args.inputs, "mirrored", output, |clip, stage| Ok(edit::mirror(clip, &stage.robot.character)?))
}
