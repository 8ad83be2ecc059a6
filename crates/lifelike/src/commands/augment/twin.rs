//! `lifelike augment twin`: references in the nominal simulation and on a twin, side by side.

use std::path::PathBuf;
use std::sync::Arc;

use lifelike_augmentation::gap;
use lifelike_augmentation::replay::{Measuring, on_twin};
use lifelike_robot::Robot;
use lifelike_sim::trace::container;
use lifelike_sim::twin::TwinSpec;
use serde_json::json;

use super::{page, sources};
use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::Output;

/// Try everything before a robot is measured: run references in the nominal simulation and on a twin, whose truth is hidden.
///
/// A twin is a simulation richer than the nominal one. It has motors with resistance and back-EMF, 12-bit encoders, and
/// friction under load (BAM's M6). Gears have play and flex, commands arrive late, the supply sags, and parts differ in
/// mass and shape. One seed is one robot. The traces contain positions, velocities, currents, and the positions of
/// markers on bodies.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike augment excite --robot kickbot.xml -o references
  lifelike augment twin references --robot kickbot.xml --seed 1 -o traces
  # backlash = 0.01, sag = 0.3, ...
  lifelike augment twin references --robot kickbot.xml --spec worse.toml -o traces
  lifelike train augmentation --plan augmentation 'traces=[\"traces\"]' augmentation.class=xm430 \\
      -o runs/xm430")]
pub struct Args {
    /// References: traces of `lifelike augment excite`, or folders of them.
    #[arg(required = true)]
    pub references: Vec<PathBuf>,
    /// The robot: a built-in one's name, or its MJCF or URDF file.
    #[arg(short = 'R', long)]
    pub robot: String,
    /// Which robot of its kind.
    #[arg(long)]
    pub seed: Option<u64>,
    /// Distribution of the twin's parameters (TOML); missing keys keep their defaults.
    #[arg(long, value_name = "FILE")]
    pub spec: Option<PathBuf>,
    /// Write the actuators alone, without bodies.
    #[arg(long)]
    pub no_bodies: bool,
    /// Folder of the traces.
    #[arg(short, long, value_parser = crate::destination::folder)]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let mut spec = match &args.spec {
        None => TwinSpec::default(),
        Some(path) => sources::described(path)?,
    };
    spec.seed = args.seed.unwrap_or(spec.seed);
    let robot = Arc::new(Robot::load(&args.robot)?);
    let references = sources::traces(&args.references)?;
    let mut measuring = Measuring::default();
    if args.no_bodies {
        measuring.bodies = None;
    }
    std::fs::create_dir_all(&args.output).map_err(CliError::write(&args.output))?;
    let mut gaps = Vec::new();
    for some in references.chunks(measuring.environments) {
        for trace in on_twin(some, &robot, &robot, &spec, &measuring)? {
            container::save(&trace, &crate::destination::named(&args.output, &trace.name, container::EXTENSION)?)?;
            gaps.extend(gap::gaps(&trace));
        }
    }
    let summary = gap::summary(&gaps);
    let value = json!({ "runs": references.len(), "folder": args.output, "twin": spec, "gap": summary });
    output.result(&value, || {
        let next = NextCommand::new("augment report").word(args.output.display()).word("-o").word("report");
        let runs = references.len();
        format!(
            "{}\n{runs} traces in {}\nnext: {next}\n",
            crate::output::fitted(&page::summary(&summary)),
            args.output.display()
        )
    })
}
