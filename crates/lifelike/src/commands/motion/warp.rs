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
  lifelike motion warp builtin:bow --speed 0.8 -o data/directed
  lifelike motion warp builtin:wave --key 1.3=2.0 --key 2.9=3.2 -o data/directed --name late_wave

--key IN=OUT moves the event at IN seconds to OUT seconds. Between keys, time is smooth and never runs backwards. Before the
first key the clip is stretched to it; after the last one it continues at its own pace. Gravity is not warped, so jumps and
fast steps tolerate little. Joints that become too fast for their actuators are listed.
Without --name, results are named NAME-x0.8 (speed) or NAME-warped (keys); several speeds of one clip fit in one folder.")]
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
