//! `lifelike augment excite`: reference motions that show what a robot's actuators do.

use std::path::PathBuf;

use lifelike_augmentation::references::authored;
use lifelike_augmentation::references::coverage::{Coverage, coverage};
use lifelike_augmentation::references::random::{self, RandomSpec};
use lifelike_report::{Cell, Column, Table};
use lifelike_robot::Robot;
use lifelike_sim::trace::container;
use serde_json::json;

use super::sources;
use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::Output;

/// Make reference motions for logging a robot that is fixed to the world (thesis 2.3.3).
///
/// Random: end effectors along B-splines of order 0 to 4 between places that they can reach, joints by inverse kinematics; or, with
/// --poses, what a person wrote as poses at times. Classes are the profile's groups of actuators ([actuator.NAME]): one network learns to
/// serve a group. Shown is what of each joint's range and speed they reach. Send the targets to the
/// robot and log what it does (`augment simulate` reads logs), or try everything on a twin first (`augment twin`).
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike augment excite --robot kickbot.xml -o references
  lifelike augment excite --robot kickbot.xml --runs 100 --seconds 30 --seed 2 -o references
  lifelike augment excite --robot kickbot.xml --poses experiments/poses/kickbot --speed 2 -o tests")]
pub struct Args {
    /// The robot: a built-in one's name, or its MJCF or URDF file.
    #[arg(short = 'R', long)]
    pub robot: String,
    /// Random motions; orders 0 to 4 take turns.
    #[arg(long, default_value_t = 60, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub runs: u64,
    /// Length of each (s).
    #[arg(long, default_value_t = 30.0)]
    pub seconds: f64,
    /// Key of all randomness.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Authored motions instead: files that end in .poses.toml, or folders of them.
    #[arg(long, num_args = 1.., value_name = "FILE")]
    pub poses: Vec<PathBuf>,
    /// Factor on the speed of authored motions.
    #[arg(long, default_value_t = 1.0, requires = "poses")]
    pub speed: f64,
    /// Folder of the references, a trace each.
    #[arg(short, long, value_parser = crate::destination::folder)]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    for (name, value, most) in [("--seconds", args.seconds, 3600.0), ("--speed", args.speed, 100.0)] {
        if !(value > 0.0 && value <= most) {
            return Err(CliError::Usage(format!("{name}: expected a number above 0, at most {most}, got {value}")));
        }
    }
    let robot = Robot::load(&args.robot)?;
    let references = match args.poses.as_slice() {
        [] => {
            let spec = RandomSpec {
                seed: args.seed,
                runs: args.runs as usize,
                seconds: args.seconds,
                ..RandomSpec::default()
            };
            random::draw(&robot, &spec)?
        }
        poses => {
            let files = sources::files(poses, &[authored::EXTENSION])?;
            let load = |file: &PathBuf| authored::load(file, &robot, args.seconds, args.speed);
            files.iter().map(load).collect::<Result<Vec<_>, _>>()?
        }
    };
    let covered = coverage(&robot, &references)?;
    std::fs::create_dir_all(&args.output).map_err(CliError::write(&args.output))?;
    for trace in &references {
        container::save(trace, &crate::destination::named(&args.output, &trace.name, container::EXTENSION)?)?;
    }
    let value = json!({ "runs": references.len(), "folder": args.output, "coverage": covered });
    output.result(&value, || {
        let next = NextCommand::new("augment twin")
            .word(args.output.display())
            .word("--robot")
            .word(&args.robot)
            .word("-o")
            .word("traces");
        format!(
            "{}\n{} runs in {}\nnext: {next}\n",
            crate::output::fitted(&table(&covered)),
            references.len(),
            args.output.display()
        )
    })
}

fn table(covered: &[Coverage]) -> Table {
    let mut table = Table::new(
        "What the references ask of each joint",
        vec![
            Column::text("joint"),
            Column::number("of its range", "%"),
            Column::number("of position and velocity", "%"),
            Column::number("median speed", "rad/s"),
            Column::number("95% below", "rad/s"),
            Column::number("reversals", "1/s"),
        ],
    );
    let row = |own: &Coverage| {
        vec![
            Cell::text(own.joint.clone()),
            Cell::number(100.0 * own.reached, 0),
            Cell::number(100.0 * own.visited, 0),
            Cell::number(own.speed[0], 2),
            Cell::number(own.speed[1], 2),
            Cell::number(own.reversals, 2),
        ]
    };
    table.rows = covered.iter().map(row).collect();
    table
}
