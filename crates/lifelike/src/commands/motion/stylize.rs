//! `lifelike motion stylize`: larger, smaller, calmer.

use std::path::PathBuf;

use lifelike_motion::edit::{self, Amplify, Around};

use super::direct::Common;
use crate::error::CliError;
use crate::output::Output;

/// Change the style of motion: larger or smaller movements, more or less of what is quick, smoother.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike motion stylize builtin:walk --joints arms --gain 1.6 -o data/directed --name march_arms
  lifelike motion stylize builtin:sway_dance --gain 0.6 -o data/directed --name shy_dance
  lifelike motion stylize data/lima/wave.motion.safetensors --joints right_arm --gain 1.3 \\
      --above 0.8 -o data/directed
  lifelike motion stylize data/lima/walk.motion.safetensors --smooth 4 -o data/directed

--joints takes joints by name and parts of the body: all, upper_body, arms, left_arm, right_arm, legs, left_leg,
right_leg, head, torso. Joints stay within their ranges. If legs change, standing feet are put back on the
ground. With both, smoothing comes before --gain. Without --name, results are named NAME-stylized.")]
pub struct Args {
    /// Clips: files, folders of them, or patterns; anything but *.motion.safetensors is retargeted first.
    #[arg(required = true)]
    pub inputs: Vec<PathBuf>,
    /// Joints and parts of the body to change.
    #[arg(long, value_delimiter = ',', default_value = "all")]
    pub joints: Vec<String>,
    /// Multiply how far joints are from their mean: above 1 is more, below 1 less.
    #[arg(long, required_unless_present = "smooth")]
    pub gain: Option<f64>,
    /// Multiply only what is faster than this (Hz), not how far joints are from their mean.
    #[arg(long, value_name = "HZ", requires = "gain")]
    pub above: Option<f64>,
    /// Take away what is faster than this (Hz), without delay.
    #[arg(long, value_name = "HZ")]
    pub smooth: Option<f64>,
    /// Folder, name and robot of the result.
    #[command(flatten)]
    pub common: Common,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    args.common.each(&args.inputs, "stylized", output, |clip, stage| {
        let (character, anatomy) = (&stage.robot.character, &stage.robot.anatomy);
        let joints = stage.joints(&args.joints)?;
        let mut clip = clip.clone();
        if let Some(cutoff) = args.smooth {
            clip = edit::smooth(&clip, character, anatomy, &joints, cutoff, &stage.options)?;
        }
        if let Some(gain) = args.gain {
            let around = args.above.map_or(Around::Mean, Around::LowPass);
            clip = edit::amplify(&clip, character, anatomy, &Amplify { joints, gain, around }, &stage.options)?;
        }
        Ok(clip)
    })
}
