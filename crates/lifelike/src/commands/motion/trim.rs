//! `lifelike motion trim`: a stretch of a clip.

use std::path::PathBuf;

use lifelike_motion::edit;

use super::direct::Common;
use crate::error::CliError;
use crate::output::Output;

/// Cut motion to the stretch between two times.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike motion trim builtin:walk --start 2.5 --end 4.5 -o data/directed --name two_steps
  lifelike motion trim data/lima/wave.motion.safetensors --end 3 -o data/directed

Results are called NAME-trimmed where no --name is given.")]
pub struct Args {
    /// Clips: files, folders of them, or patterns; anything but *.motion.safetensors is retargeted first.
    #[arg(required = true)]
    pub inputs: Vec<PathBuf>,
    /// First instant (s).
    #[arg(long, default_value_t = 0.0)]
    pub start: f64,
    /// Last instant (s); the clip's end where not given.
    #[arg(long)]
    pub end: Option<f64>,
    /// Folder, name and robot of the result.
    #[command(flatten)]
    pub common: Common,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    args.common.each(&args.inputs, "trimmed", output, |clip, _| Ok(edit::trim(clip, Some(args.start), args.end)?))
}
