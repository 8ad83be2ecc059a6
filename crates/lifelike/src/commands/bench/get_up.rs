//! `lifelike bench get-up`: robots that stand up after they were dropped.

use std::path::{Path, PathBuf};

use lifelike_evaluation::get_up::{GetUpOptions, Risen};
use lifelike_report::ReportBuilder;
use lifelike_robot::Robot;

use crate::commands::controller_file::Loaded;
use crate::commands::eval;
use crate::commands::physics::{self, Physics};
use crate::commands::script;
use crate::error::CliError;
use crate::output::Output;
use crate::progress::Progress;

/// Measure how many robots stand up after they were dropped, and how soon.
///
/// Each robot falls from a random turn while its motors brake. Then the controller is asked to stand, after the script. It
/// is up when it stands for a second: upright within 20 degrees, its root above 85% of its height in the stand, on both
/// feet and nothing else. The folder gets get-up.json and report.html, which plays the first episodes.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike bench get-up --policy lima-blind --script lima -o runs/get-up
  lifelike bench get-up --policy runs/get-up -o out --episodes 100")]
pub struct Args {
    /// The policy.
    #[arg(short, long)]
    policy: PathBuf,
    /// The script that gets up before the policy stands: a TOML file, or the name of a robot that has one.
    #[arg(long)]
    script: Option<PathBuf>,
    /// The robot: a name, or an MJCF or URDF file; what the policy was trained for where not given.
    #[arg(short, long)]
    robot: Option<String>,
    /// Folder of the results.
    #[arg(short, long, value_parser = crate::destination::folder)]
    output: PathBuf,
    /// Number of dropped robots.
    #[arg(long, default_value_t = 500)]
    episodes: usize,
    /// Longest time to get up (s).
    #[arg(long, default_value_t = 10.0)]
    seconds: f64,
    /// Seed of the poses.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    physics: Physics,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    physics::available(&args.physics.engine)?;
    let options = GetUpOptions { episodes: args.episodes, seconds: args.seconds, seed: args.seed };
    if !(options.seconds > 0.0 && options.seconds <= 3600.0 && (1..=eval::STARTS).contains(&options.episodes)) {
        let text = format!("--seconds must be above 0 and at most 3600, --episodes from 1 to {}", eval::STARTS);
        return Err(CliError::Usage(text));
    }
    let loaded = Loaded::load(&args.policy, args.robot.as_deref(), None)?;
    let script = args.script.as_deref().map(script::read).transpose()?;
    let robot = loaded.controller.robot();
    args.physics.require_ready(robot)?;
    let simulate = |terrain, environments| args.physics.simulate(terrain, robot, environments);
    let mut progress = Progress::new(output, "getting up", options.episodes as u64);
    let found = loaded.setup(&simulate).get_up(script.as_ref(), &options, |done, of| {
        progress.update(done as u64, of as u64, String::new);
    })?;
    progress.finish();
    let report = save(&found, robot, &args.policy, &args.output)?;
    output.result(&found, || format!("{}report: {}\n", crate::output::fitted(&found.table()), report.display()))
}

/// Writes `get-up.json` and `report.html`; returns the report's path.
fn save(found: &Risen, robot: &Robot, policy: &Path, folder: &Path) -> Result<PathBuf, CliError> {
    std::fs::create_dir_all(folder).map_err(CliError::write(folder))?;
    crate::output::write_json(&folder.join("get-up.json"), found)?;
    let path = folder.join("report.html");
    ReportBuilder::new(format!("{} gets up", policy.display()))
        .subtitle("The first dropped robots, beside the stand that is asked for.")
        .fact("robot", found.robot.clone())
        .fact("engine", found.engine.clone())
        .fact("seed", found.seed.to_string())
        .table(found.table())
        .playback(&robot.character, &found.playbacks())
        .write(&path)?;
    Ok(path)
}
