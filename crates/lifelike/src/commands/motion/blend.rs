//! `lifelike motion blend`: between two motions.

use std::path::PathBuf;

use lifelike_motion::edit;

use super::direct::Common;
use crate::error::CliError;
use crate::output::Output;

/// Blend two motions: a motion in between.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike motion blend builtin:walk builtin:march --weight 0.3 -o data/directed

Both begin together; the result is as long as the shorter and walks at the mixed speed. Feet that do not step together
slide in between; warp one of them first so that they do. It is called A~B where no --name is given.")]
pub struct Args {
    /// The clip that the result starts from.
    pub a: PathBuf,
    /// The clip that is blended in.
    pub b: PathBuf,
    /// Share of the second clip: 0 is the first, 1 the second.
    #[arg(short, long, default_value_t = 0.5)]
    pub weight: f64,
    /// Folder, name and robot of the result.
    #[command(flatten)]
    pub common: Common,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let stage = args.common.stage([args.a.as_path(), args.b.as_path()])?;
    let clip = edit::blend(&stage.clip(&args.a)?, &stage.clip(&args.b)?, args.weight)?;
    let made = args.common.write(clip, &stage)?;
    output.result(&made, || made.text())
}
