//! `lifelike augment estimate`: the whole state of a robot from logs of its joints.

use std::path::PathBuf;
use std::sync::Arc;

use lifelike_augmentation::{Augmentation, gap, replay};
use lifelike_robot::Robot;
use lifelike_sim::trace::{Trace, container};
use serde_json::json;

use super::{FeedbackName, page, sources};
use crate::commands::physics::Physics;
use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::Output;

/// Estimate joints and bodies of a robot from logs of its joints alone.
///
/// The log's commands are simulated, and the simulation is corrected. Actuators are corrected by what was learned of
/// their class, and read the log's own measurements if it has some. Bodies are corrected by what was learned from
/// markers; the log needs none.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike augment estimate log.csv --map columns.toml --robot kickbot.xml \\
      --augmentation xm430.augmentation.safetensors \\
      --augmentation body.augmentation.safetensors -o estimated
  lifelike augment estimate traces/ --robot kickbot.xml \\
      --augmentation xm430.augmentation.safetensors -o estimated")]
pub struct Args {
    /// Logs: tables with --map (files, or folders of *.csv and *.mcap), else traces with commands (files, or folders).
    #[arg(required = true)]
    pub logs: Vec<PathBuf>,
    /// The robot: a built-in one's name, or its MJCF or URDF file.
    #[arg(short = 'R', long)]
    pub robot: String,
    /// Map of the tables' columns (TOML), as for `lifelike augment simulate`.
    #[arg(long, value_name = "FILE")]
    pub map: Option<PathBuf>,
    /// Corrections, once for each class of actuators or bodies.
    #[arg(long, required = true, value_name = "FILE")]
    pub augmentation: Vec<PathBuf>,
    /// Earlier errors that corrections of measured blocks read; corrections of other blocks read none.
    #[arg(long, value_enum, default_value = "measured")]
    pub feedback: FeedbackName,
    /// Engine and threads.
    #[command(flatten)]
    pub physics: Physics,
    /// Folder of the estimates: traces whose states are corrected.
    #[arg(short, long, value_parser = crate::destination::folder)]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let robot = Arc::new(Robot::load(&args.robot)?);
    let augmentations = args.augmentation.iter().map(|file| Augmentation::load(file)).collect::<Result<Vec<_>, _>>()?;
    let logs = match &args.map {
        None => sources::traces(&args.logs)?,
        Some(map) => sources::tables(&args.logs, map, &robot)?,
    };
    let mut simulation = args.physics.simulate(None, &robot, 1)?;
    std::fs::create_dir_all(&args.output).map_err(CliError::write(&args.output))?;
    let (mut before, mut after) = (Vec::new(), Vec::new());
    for log in &logs {
        let mut trace = with_bodies(log, &robot, &augmentations, &mut simulation)?;
        before.extend(gap::gaps(&trace));
        for augmentation in &augmentations {
            trace = augmentation.corrected(&trace, args.feedback.into())?;
        }
        after.extend(gap::gaps(&trace));
        container::save(&trace, &crate::destination::named(&args.output, &trace.name, container::EXTENSION)?)?;
    }
    let (before, after) = (gap::summary(&before), gap::summary(&after));
    let value = json!({ "runs": logs.len(), "folder": args.output, "simulation": before, "estimate": after });
    output.result(&value, || {
        let next = NextCommand::new("augment report").word(args.output.display()).word("-o").word("report");
        let tables = match before.is_empty() {
            true => String::new(),
            false => format!(
                "simulation:\n{}\nestimate:\n{}\n",
                crate::output::fitted(&page::summary(&before)),
                crate::output::fitted(&page::summary(&after))
            ),
        };
        format!("{tables}{} estimates in {}\nnext: {next}\n", logs.len(), args.output.display())
    })
}

/// The log beside its simulation, bodies included where some correction is of bodies: measured ones where the log has them.
fn with_bodies(
    log: &Trace,
    robot: &Robot,
    augmentations: &[Augmentation],
    simulation: &mut Box<dyn lifelike_sim::Simulation>,
) -> Result<Trace, CliError> {
    let classes: Vec<&str> = augmentations.iter().map(|own| own.header().inputs.class.as_str()).collect();
    let is_joint = |name: &String| robot.layout.joints.contains(name);
    let mut joints = log.clone();
    joints.blocks.retain(|block| is_joint(&block.name));
    let known = |class: &&&str| joints.blocks.iter().all(|block| block.class != **class);
    let class = classes.iter().find(known).copied();
    let mut trace = replay::replayed(&joints, simulation, class)?;
    for block in &mut trace.blocks {
        let Some(own) = log.blocks.iter().find(|own| own.name == block.name && own.class == block.class) else {
            continue;
        };
        if !is_joint(&block.name) {
            block.measured.clone_from(&own.measured);
            block.selection.clone_from(&own.selection);
        }
    }
    Ok(trace)
}
