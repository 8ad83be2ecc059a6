//! `lifelike augment simulate`: logs and what a simulation makes of their commands, side by side.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_augmentation::{gap, replay};
use lifelike_robot::Robot;
use lifelike_sim::trace::{Trace, container};
use serde_json::json;

use super::{page, sources};
use crate::commands::physics::Physics;
use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::Output;

/// Simulate the commands of logs, and write traces that have simulated and measured states side by side.
///
/// Logs are those of BAM's test benches (a servo that turns a weight on an arm, JSON), resampled to --rate. With
/// --robot and --map, they are tables of a whole robot (CSV, or ROS 2 bags of JointState); the map names columns and
/// units. The simulation starts in the log's first state and runs freely.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike augment simulate logs/ -o traces/nominal
  lifelike augment identify logs/ --friction m6 -o xl330.toml
  lifelike augment simulate logs/ --servo xl330.toml -o traces/fitted
  lifelike augment simulate walk.csv --robot mine.xml --map columns.toml -o traces/mine

A map of columns (units: si, deg, deg/s, rpm, ticks4096, mA, mV, mm):
  time = \"t\"
  rate = 50.0
  [block.left_knee]                    # a joint of the robot
  class = \"xm430\"
  reference.position = { column = \"left_knee_goal\", unit = \"deg\" }
  measured.position = { column = \"left_knee\", unit = \"ticks4096\" }
Of a ROS 2 bag (*.mcap): time = \"stamp\", columns \"left_knee.position\", .velocity or .effort,
with the topic before them where several have one: \"/goals/left_knee.position\"")]
pub struct Args {
    /// Logs: files, or folders of *.json (with --map of *.csv and *.mcap).
    #[arg(required = true)]
    pub logs: Vec<PathBuf>,
    /// The servo's model: a file of `lifelike augment identify`, or a data sheet's (xl330, sts3250); as the logs say if not given.
    #[arg(long)]
    pub servo: Option<String>,
    /// Rows per second of a bench's traces (Hz).
    #[arg(long, default_value_t = 200.0, allow_negative_numbers = true)]
    pub rate: f64,
    /// The robot of tables: a built-in one's name, or its MJCF or URDF file.
    #[arg(short = 'R', long, requires = "map")]
    pub robot: Option<String>,
    /// Map of the tables' columns (TOML).
    #[arg(long, requires = "robot", value_name = "FILE")]
    pub map: Option<PathBuf>,
    /// Engine and threads.
    #[command(flatten)]
    pub physics: Physics,
    /// Folder of the traces.
    #[arg(short, long, value_parser = crate::destination::folder)]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    crate::bounds::row_rate("--rate", args.rate)?;
    let traces = match (&args.robot, &args.map) {
        (Some(robot), Some(map)) => of_robot(args, robot, map)?,
        _ => {
            let logs = sources::bench_logs(&args.logs)?;
            let servo = sources::servo(args.servo.as_deref(), &logs)?;
            logs.iter().map(|log| log.at(args.rate).simulated(log, &servo.bench(log))).collect()
        }
    };
    std::fs::create_dir_all(&args.output).map_err(CliError::write(&args.output))?;
    let mut files = Vec::with_capacity(traces.len());
    for trace in &traces {
        let file = crate::destination::named(&args.output, &trace.name, container::EXTENSION)?;
        container::save(trace, &file)?;
        files.push(file);
    }
    let summary = gap::summary(&traces.iter().flat_map(gap::gaps).collect::<Vec<_>>());
    let value = json!({ "files": files, "gap": summary });
    output.result(&value, || {
        let next = NextCommand::new("augment report").word(args.output.display()).word("-o").word("report");
        format!(
            "{}\n{} traces in {}\nnext: {next}\n",
            crate::output::fitted(&page::summary(&summary)),
            files.len(),
            args.output.display()
        )
    })
}

/// The logs of a whole robot beside its simulation.
fn of_robot(args: &Args, robot: &str, map: &Path) -> Result<Vec<Trace>, CliError> {
    let robot = Arc::new(Robot::load(robot)?);
    let mut simulation = args.physics.simulate(None, &robot, 1)?;
    let logs = sources::tables(&args.logs, map, &robot)?;
    logs.iter().map(|log| Ok(replay::replayed(log, &mut simulation, None)?)).collect()
}
