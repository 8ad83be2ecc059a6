//! `lifelike bench robustness`: the disturbances that a policy withstands.

use std::path::{Path, PathBuf};

use lifelike_evaluation::EvaluationOptions;
use lifelike_evaluation::robustness::{Disturbance, Robustness, RobustnessOptions, sweep};
use lifelike_report::ReportBuilder;
use lifelike_robot::Robot;
use lifelike_robot::controller::EXTENSION;

use crate::commands::controller_file::Loaded;
use crate::commands::physics::{self, Physics};
use crate::commands::{clips, eval};
use crate::error::CliError;
use crate::next::{self, NextCommand};
use crate::output::Output;
use crate::progress::Progress;

/// Measure survival and tracking error of a policy against the size of disturbances.
///
/// Pushes on root, head, hands and feet; punches; friction; masses; encoders that are off; hills; stairs climbed in the air; abrupt
/// switches between clips. The folder gets robustness.json and report.html, with the curves and an episode that survived and
/// one that fell of each. The result is the same for the same seed, whatever the threads.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike bench robustness --policy lima --motions builtin -o runs/robustness
  lifelike bench robustness --policy runs/walk \\
      --motions @experiments/track-20-test.txt -o out --quick
  lifelike bench robustness --policy runs/walk --motions walk.bvh -o out \\
      --only 'push root' --only hills
  lifelike bench robustness --policy lima --motions builtin -o out \\
      --only 'push root' --sizes 0.29,0.87,1.46 --seconds 90
  lifelike bench robustness --policy assets/g1-nc.controller.safetensors \\
      --motions idle.motion.safetensors -o out --only punches --sizes 1.46 --seconds 90")]
pub struct Args {
    /// The policy.
    #[arg(short, long)]
    policy: PathBuf,
    /// The robot: a name, or an MJCF or URDF file; what the policy was trained for where not given.
    #[arg(short, long)]
    robot: Option<String>,
    /// Clips to follow: files, folders, patterns, or @list.txt with one of them per line.
    #[arg(short, long, required = true, num_args = 1..)]
    motions: Vec<PathBuf>,
    #[command(flatten)]
    layout: clips::LayoutArgument,
    /// Folder of the results.
    #[arg(short, long, value_parser = crate::destination::folder)]
    output: PathBuf,
    /// Few sizes, short episodes.
    #[arg(long)]
    quick: bool,
    /// Only disturbances of these names.
    #[arg(long)]
    only: Vec<String>,
    /// Sizes in place of the disturbance's own, in its unit, from the mildest on; needs one --only.
    #[arg(long, value_delimiter = ',')]
    sizes: Vec<f64>,
    /// Longest episode (s); 10, or 4 with --quick.
    #[arg(long)]
    seconds: Option<f64>,
    /// Episodes per clip; 5, or 2 with --quick.
    #[arg(long)]
    starts: Option<usize>,
    /// Seed of directions, moments, places, offsets and hills.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    physics: Physics,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    physics::available(&args.physics.engine)?;
    let options = options(args)?;
    let loaded = Loaded::load(&args.policy, args.robot.as_deref(), None)?;
    let robot = loaded.controller.robot();
    let clips = clips::load_as(&args.motions, args.layout, robot)?;
    let simulate = |terrain, environments| args.physics.simulate(terrain, robot, environments);
    let mut progress = Progress::new(output, "disturbing", 1);
    let found = sweep(&loaded.setup(&simulate), &clips, &options, |what, done, of| {
        progress.update(done as u64, of as u64, || what.to_string());
    })?;
    progress.finish();
    let report = save(&found, robot, &args.policy, &args.output)?;
    output.result(&found, || {
        let tables: String = found.tables().iter().map(|t| crate::output::fitted(t) + "\n").collect();
        // A controller is what an export makes.
        let is_policy = args.policy.exists() && !args.policy.to_string_lossy().ends_with(EXTENSION);
        let export = NextCommand::new("export").word(args.policy.display());
        let next = is_policy.then(|| args.robot.iter().fold(export, |line, robot| line.robot(robot)));
        format!("{tables}report: {}\n{}", report.display(), next::lines(next.as_slice()))
    })
}

fn options(args: &Args) -> Result<RobustnessOptions, CliError> {
    let seconds = args.seconds.unwrap_or(if args.quick { 4.0 } else { 10.0 });
    let starts = args.starts.unwrap_or(if args.quick { 2 } else { 5 });
    if !(seconds > 0.0 && seconds <= 3600.0 && (1..=eval::STARTS).contains(&starts)) {
        let text = format!("--seconds must be above 0 and at most 3600, --starts from 1 to {}", eval::STARTS);
        return Err(CliError::Usage(text));
    }
    let names = || Disturbance::ALL.iter().map(|d| d.name());
    if let Some(unknown) = args.only.iter().find(|only| !names().any(|name| name == only.as_str())) {
        let all = names().collect::<Vec<_>>().join("', '");
        return Err(CliError::Usage(format!("--only: no disturbance '{unknown}'; there are '{all}'")));
    }
    let finite = args.sizes.iter().all(|size| size.is_finite() && *size >= 0.0);
    if !(args.sizes.is_empty() || finite && args.only.len() == 1) {
        return Err(CliError::Usage("--sizes: expected finite numbers from 0 on, and one --only".into()));
    }
    let wanted = |d: &Disturbance| args.only.is_empty() || args.only.iter().any(|only| only == d.name());
    Ok(RobustnessOptions {
        seed: args.seed,
        few: args.quick,
        sizes: args.sizes.clone(),
        disturbances: Disturbance::ALL.into_iter().filter(wanted).collect(),
        evaluation: EvaluationOptions { seconds, starts, ..EvaluationOptions::default() },
    })
}

/// Writes `robustness.json` and `report.html`; returns the report's path.
fn save(found: &Robustness, robot: &Robot, policy: &Path, folder: &Path) -> Result<PathBuf, CliError> {
    std::fs::create_dir_all(folder).map_err(CliError::write(folder))?;
    crate::output::write_json(&folder.join("robustness.json"), found)?;
    let page = ReportBuilder::new(format!("Disturbances that {} withstands", policy.display()))
        .subtitle("Survival and tracking error against the size of disturbances; the page draws all ground level.")
        .fact("robot", found.robot.clone())
        .fact("engine", found.engine.clone())
        .fact("clips", found.clips.len().to_string())
        .fact("seed", found.seed.to_string())
        .playback(&robot.character, &found.playbacks())
        .curves(found.curves())
        .measured();
    let path = folder.join("report.html");
    found.tables().into_iter().fold(page, ReportBuilder::table).write(&path)?;
    Ok(path)
}
