//! `lifelike inspect FILE`: what is in it.

mod checkpoint;
mod clip;
mod controller;
mod look;
mod machine;
mod networks;
mod next_steps;
mod onnx;
mod robot;
mod run;

use std::path::{Path, PathBuf};

use lifelike_motion::formats::{self, FileMotion, ReadOptions};

use crate::commands::clips;
use crate::commands::motion::fetched_g1;
use crate::destination;
use crate::error::CliError;
use crate::output::Output;
use crate::shipped;

/// Describe a robot, a motion, a network, a run or this machine, and print the next step.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike inspect lima                        # a robot that comes with the program
  lifelike inspect g1                          # the Unitree G1, once fetched: lifelike fetch g1
  lifelike inspect g1 --look                   # a page: shapes, joints as sliders, masses, frames
  lifelike inspect walk.bvh                    # captured motion, in any format that is read
  lifelike inspect walk.motion.safetensors     # motion of a robot
  lifelike inspect runs/tracker                # a run: plan, progress, checkpoints
  lifelike inspect --json lima.controller      # a network of the program: inputs by name
  lifelike inspect policy.onnx                 # a policy of another stack: its layout
  lifelike inspect --machine                   # vector instructions, cores, peak rates, memory
  LIFELIKE_SIMD=portable lifelike inspect --machine    # with what every machine has")]
pub struct Args {
    /// A file, the folder of a run, or the name of a robot that comes with the program.
    #[arg(required_unless_present = "machine")]
    pub what: Option<PathBuf>,
    /// Layout of the motion.
    #[command(flatten)]
    pub layout: clips::LayoutArgument,
    /// This machine: vector instructions, cores, peak speed of one core (measured), memory.
    /// LIFELIKE_SIMD forces other vector instructions.
    #[arg(long, conflicts_with = "what")]
    pub machine: bool,
    /// Write report.html of a robot: joints as sliders, contact shapes, masses, frames, left and right.
    #[arg(long, requires = "what")]
    pub look: bool,
    /// Folder of the page [default: the robot's name and -look].
    #[arg(short, long, value_name = "FOLDER", requires = "look", value_parser = destination::folder)]
    pub output: Option<PathBuf>,
}

/// Kind of a path, by its name.
enum Kind {
    Robot,
    Run,
    Motion,
    Checkpoint,
    Onnx,
}

fn kind(path: &Path) -> Kind {
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    match extension.as_deref() {
        _ if path.is_dir() => Kind::Run,
        _ if !path.exists() => Kind::Robot,
        Some("xml" | "mjcf" | "urdf") => Kind::Robot,
        Some("onnx") => Kind::Onnx,
        Some("safetensors") if formats::of_file(path).is_none() => Kind::Checkpoint,
        _ => Kind::Motion,
    }
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let Some(path) = args.what.as_deref() else { return machine::inspect(output) };
    let network = shipped::with_full_name(path).filter(|_| !path.exists()).map(shipped::Shipped::file).transpose()?;
    let path = network.as_deref().unwrap_or(path);
    let named = path.components().count() > 1 || path.extension().is_some();
    if named && !path.exists() {
        return Err(CliError::Input(format!("{}: expected a file or folder, got nothing there", path.display())));
    }
    let kind = kind(path);
    if args.look && !matches!(kind, Kind::Robot) {
        let got = path.display();
        return Err(CliError::Input(format!(
            "--look: expected a robot, got {got}; motion is shown by `lifelike play`"
        )));
    }
    match kind {
        Kind::Robot => {
            let name = path.to_string_lossy();
            let page = args.look.then(|| look::write(&name, args.output.as_deref())).transpose()?;
            robot::inspect(&name, page.as_deref(), output)
        }
        Kind::Run => run::inspect(path, output),
        Kind::Checkpoint => checkpoint::inspect(path, output),
        Kind::Onnx => onnx::inspect(path, output),
        Kind::Motion => match formats::read(path, &reading(args.layout))? {
            FileMotion::Robot(clip) => clip::inspect_motion(path, &clip, output),
            FileMotion::Source(clip) => clip::inspect_source(path, &clip, output),
        },
    }
}

/// Returns options of reading, with the robot of most files that name none.
fn reading(layout: clips::LayoutArgument) -> ReadOptions {
    let robot = fetched_g1().map(|robot| robot.character);
    ReadOptions { robot, layout: layout.layout, ..ReadOptions::default() }
}
