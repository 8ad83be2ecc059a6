//! `lifelike motion warp`: the same motion at other times.

use std::path::PathBuf;

use lifelike_motion::edit::{self, Warp};

use super::direct::Common;
use crate::error::CliError;
use crate::output::Output;

/// Change when things happen: faster, slower, or events at given times.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike motion warp motions/bow.keys.toml --speed 0.8 -o data/directed
  lifelike motion warp motions/wave.keys.toml --key 1.3=2.0 --key 2.9=3.2 -o data/directed --name late_wave

--key IN=OUT puts what happens at IN seconds at OUT seconds. Between keys time runs smoothly and never backwards; before
the first the clip fits itself to it, after the last it goes on at its own pace. Gravity is not warped: jumps and fast
steps stand little of it. Joints that become too fast for their actuators are listed.
Where no --name is given, results are called NAME-x0.8 by their speed, NAME-warped by keys: speeds of one clip go together.")]
pub struct Args {
    /// Clips: files, folders of them, or patterns; anything but *.motion.safetensors is retargeted first.
    #[arg(required = true)]
    pub inputs: Vec<PathBuf>,
    /// So many times as fast.
    #[arg(long, required_unless_present = "keys", conflicts_with = "keys")]
    pub speed: Option<f64>,
    /// An event's time and its new time (s); may be given several times.
    #[arg(long = "key", value_name = "IN=OUT", value_parser = key)]
    pub keys: Vec<(f64, f64)>,
    /// Folder, name and robot of the result.
    #[command(flatten)]
    pub common: Common,
}

fn key(text: &str) -> Result<(f64, f64), String> {
    let times = text.split_once('=').and_then(|(from, to)| Some((from.trim().parse().ok()?, to.trim().parse().ok()?)));
    times.ok_or_else(|| format!("expected IN=OUT in seconds, such as 1.3=2.0, got '{text}'"))
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let how = args.speed.map_or_else(|| Warp::Keys(args.keys.clone()), Warp::Speed);
    let suffix = args.speed.map_or_else(|| "warped".to_string(), |speed| format!("x{speed}"));
    args.common.each(&args.inputs, &suffix, output, |clip, _| Ok(edit::warp(clip, &how)?))
}
