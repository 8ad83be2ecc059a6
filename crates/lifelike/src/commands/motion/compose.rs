//! `lifelike motion compose`: the body of one motion with the arms of another.

use std::path::PathBuf;

use clap::ValueEnum;
use lifelike_motion::edit::{self, Compose, Length};

use super::direct::Common;
use crate::error::CliError;
use crate::output::Output;

/// Compose two motions: some joints of the one, everything else of the other.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike motion compose builtin:walk builtin:wave --joints right_arm,head -o data/directed
  lifelike motion compose builtin:march builtin:sway_dance --joints arms \\
      --length loop \\
      -o data/directed --name marching_dance
  lifelike motion compose data/lima/walk.motion.safetensors data/lima/point.motion.safetensors \\
      --joints arms --offset 2 --length return -o data/directed --name walk_and_point

--joints takes joints by name and parts of the body: all, upper_body, arms, left_arm, right_arm, legs, left_leg,
right_leg, head, torso. The result is called BASE+OTHER where no --name is given.")]
pub struct Args {
    /// The clip whose root and joints are kept.
    pub base: PathBuf,
    /// The clip whose joints are taken.
    pub other: PathBuf,
    /// Joints and parts of the body that are taken from the second clip.
    #[arg(short, long, value_delimiter = ',', required = true)]
    pub joints: Vec<String>,
    /// When the other clip begins in the base's time (s); below 0 it has begun already.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    pub offset: f64,
    /// Continuation where the other clip is over first.
    #[arg(long, value_enum, default_value = "return")]
    pub length: Policy,
    /// Time that the joints take from one clip to the other (s); 0 is abrupt.
    #[arg(long, default_value_t = 0.3)]
    pub fade: f64,
    /// Folder, name and robot of the result.
    #[command(flatten)]
    pub common: Common,
}

/// Continuation where the other clip is over first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Policy {
    /// The result ends there.
    Cut,
    /// Its last pose is held.
    Hold,
    /// It is repeated (cyclic clips only).
    Loop,
    /// The joints go back to the base's.
    Return,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let stage = args.common.stage([args.base.as_path(), args.other.as_path()])?;
    let length = match args.length {
        Policy::Cut => Length::Cut,
        Policy::Hold => Length::Hold,
        Policy::Loop => Length::Loop,
        Policy::Return => Length::Return,
    };
    let options = Compose { joints: stage.joints(&args.joints)?, offset: args.offset, length, fade: args.fade };
    let clip = edit::compose(&stage.clip(&args.base)?, &stage.clip(&args.other)?, &options)?;
    let made = args.common.write(clip, &stage)?;
    output.result(&made, || made.text())
}
