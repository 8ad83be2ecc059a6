//! `lifelike eval`: how well a policy follows.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use lifelike_evaluation::explain::{self, Explanation};
use lifelike_evaluation::verdict::summary;
use lifelike_evaluation::{Chain, Evaluation, EvaluationOptions};
use lifelike_motion::{MotionClip, container, feasibility};
use lifelike_report::{ReportBuilder, Table};
use lifelike_robot::Robot;

use crate::commands::clips;
use crate::commands::controller_file::Loaded;
use crate::commands::motion::container_in;
use crate::commands::physics::{self, Physics};
use crate::error::CliError;
use crate::output::{Output, fitted, screen};
use crate::progress::Progress;

/// Most episodes of one clip: more is a mistake.
pub const STARTS: usize = 10_000;

/// Evaluate a policy in physics: errors, survival, where and why it fell.
///
/// Every clip is followed from several frames of it, without noise. The folder gets evaluation.json and report.html,
/// which plays physics beside the reference.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike eval --policy runs/walk/tracker.policy.safetensors --motions data/lima -o report
  lifelike eval --policy p.policy.safetensors --prior m.prior.safetensors --motions a.bvh b.bvh -o report
  lifelike eval --policy p.policy.safetensors --motions @experiments/track-20-test.txt -o report
  lifelike eval --policy p.policy.safetensors --motions data/lima -o report --json | jq .overall.survival
  lifelike eval --policy p.policy.safetensors --motions kept/MDM --episodes 2048 --seconds 30 -o report
  lifelike eval --policy p.policy.safetensors --motions data/lima -o report --explain --apply data/repaired

Motions may be *.motion.safetensors, or captured motion and keyframes, which are retargeted on the way.")]
pub struct Args {
    /// The controller, or the policy.
    #[arg(short, long)]
    pub policy: PathBuf,
    /// The motion prior that the policy was trained with, where it was.
    #[arg(long)]
    pub prior: Option<PathBuf>,
    /// The robot: a name, or an MJCF or URDF file; what the policy was trained for where not given.
    #[arg(short, long)]
    pub robot: Option<String>,
    /// Clips to follow: files, folders, patterns, or @list.txt with one of them per line.
    #[arg(short, long, required = true, num_args = 1..)]
    pub motions: Vec<PathBuf>,
    /// Folder of the results.
    #[arg(short, long)]
    pub output: PathBuf,
    /// Longest episode (s).
    #[arg(long, default_value_t = 10.0)]
    pub seconds: f64,
    /// Episodes per clip, from frames spread over it.
    #[arg(long, default_value_t = 5)]
    pub starts: usize,
    /// So many episodes of exactly --seconds in place of --starts on each clip: they begin anywhere in any clip, and where
    /// one ends another begins where the robot stands (thesis 5.3.3).
    #[arg(long, conflicts_with_all = ["starts", "explain"], value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub episodes: Option<u64>,
    /// Key of the randomness of --episodes.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Say of every clip that it falls on why, and try which change of the clip would help.
    #[arg(long)]
    pub explain: bool,
    /// Write the clips that a change helps to this folder, changed.
    #[arg(long, value_name = "FOLDER", requires = "explain")]
    pub apply: Option<PathBuf>,
    /// Engine and threads.
    #[command(flatten)]
    pub physics: Physics,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    physics::available(&args.physics.engine)?;
    if !(args.seconds > 0.0 && args.seconds <= 3600.0 && (1..=STARTS).contains(&args.starts)) {
        let text = format!("--seconds must be above 0 and at most 3600, --starts from 1 to {STARTS}");
        return Err(CliError::Usage(text));
    }
    let loaded = Loaded::load(&args.policy, args.robot.as_deref(), args.prior.as_deref())?;
    let robot = loaded.controller.robot();
    args.physics.require_ready(robot)?;
    let clips = clips::load(&args.motions, robot)?;
    let chain = args.episodes.map(|episodes| Chain { episodes: episodes as usize, seed: args.seed });
    let options =
        EvaluationOptions { seconds: args.seconds, starts: args.starts, chain, ..EvaluationOptions::default() };
    let job = Job { loaded: &loaded, physics: &args.physics };
    let mut evaluation = job.run(&clips, &options, output)?;
    if args.episodes.is_none() {
        by_feasibility(&mut evaluation, &clips, robot)?;
    }
    let title = format!("{} on {} clips", args.policy.display(), clips.len());
    let explanations = args.explain.then(|| job.explain(&evaluation, &clips, &options, output)).transpose()?;
    let table = explanations.as_ref().and_then(|all| explain::table(all));
    let report = save(&evaluation, table, robot, &title, &args.output)?;
    for repaired in explanations.iter().flatten().filter_map(|e| e.repaired.as_ref()) {
        let Some(folder) = &args.apply else { break };
        container::write(&container_in(folder, &repaired.name), repaired)?;
    }
    let sentences: String = explanations.iter().flatten().map(|e| e.words() + "\n").collect();
    let result = Explained { evaluation: &evaluation, explanations };
    output.result(&result, || format!("{sentences}{}report: {}\n", text(&evaluation), report.display()))
}

/// Adds what comes of clips that can be tracked, as far as can be told without physics, and of others, apart.
fn by_feasibility(evaluation: &mut Evaluation, clips: &[MotionClip], robot: &Robot) -> Result<(), CliError> {
    let mut trackable = BTreeMap::new();
    for clip in clips {
        let found = feasibility::check(clip, &robot.character, &robot.anatomy, &robot.speeds())?;
        trackable.insert(clip.name.as_str(), found.trackable);
    }
    let is = |name: &str, wanted: bool| trackable.get(name).is_some_and(|own| *own == wanted);
    evaluation.group("called trackable", |name| is(name, true));
    evaluation.group("called untrackable", |name| is(name, false));
    Ok(())
}

/// An evaluation, and with `--explain` its explanations.
#[derive(serde::Serialize)]
struct Explained<'a> {
    #[serde(flatten)]
    evaluation: &'a Evaluation,
    #[serde(skip_serializing_if = "Option::is_none")]
    explanations: Option<Vec<Explanation>>,
}

/// A controller, ready to be evaluated.
pub struct Job<'a> {
    /// The controller.
    pub loaded: &'a Loaded,
    /// The physics.
    pub physics: &'a Physics,
}

impl Job<'_> {
    /// Evaluates on clips.
    pub fn run(
        &self,
        clips: &[MotionClip],
        options: &EvaluationOptions,
        output: &Output,
    ) -> Result<Evaluation, CliError> {
        let simulate = |terrain, n| self.physics.simulate(terrain, self.loaded.controller.robot(), n);
        let mut progress = Progress::new(output, "evaluating", clips.len() as u64);
        let evaluation = self.loaded.setup(&simulate).evaluate(clips, options, |done, of| {
            progress.update(done as u64, of as u64, String::new);
        })?;
        progress.finish();
        Ok(evaluation)
    }

    /// Explains the falls of an evaluation on these clips.
    fn explain(
        &self,
        evaluation: &Evaluation,
        clips: &[MotionClip],
        options: &EvaluationOptions,
        output: &Output,
    ) -> Result<Vec<Explanation>, CliError> {
        let simulate = |terrain, n| self.physics.simulate(terrain, self.loaded.controller.robot(), n);
        let mut progress = Progress::new(output, "explaining", 1);
        let told = explain::explain(&self.loaded.setup(&simulate), evaluation, clips, options, |clip, done, of| {
            progress.update(done as u64, of as u64, || clip.to_string());
        })?;
        progress.finish();
        Ok(told)
    }
}

/// Writes `evaluation.json` and `report.html`, with another table where there is one; returns the report's path.
pub fn save(
    evaluation: &Evaluation,
    more: Option<Table>,
    robot: &Robot,
    title: &str,
    folder: &Path,
) -> Result<PathBuf, CliError> {
    std::fs::create_dir_all(folder).map_err(CliError::write(folder))?;
    let json = serde_json::to_string_pretty(evaluation).map_err(|e| CliError::Failed(e.to_string()))?;
    let file = folder.join("evaluation.json");
    std::fs::write(&file, json).map_err(CliError::write(&file))?;
    let overall = &evaluation.overall;
    let page = ReportBuilder::new(title)
        .subtitle("Physics beside its reference: drag to turn, scroll to come closer, press space to pause.")
        .fact("robot", evaluation.robot.clone())
        .fact("engine", evaluation.engine.clone())
        .fact("episodes", overall.episodes.to_string())
        .fact("verdict", summary(evaluation.clips.iter().map(|clip| &clip.verdict)))
        .fact("survival", format!("{:.0}%", 100.0 * overall.survival))
        .fact("joint error", format!("{:.2} deg", overall.joint_error_deg));
    let page = evaluation.tables().into_iter().chain(more).fold(page, ReportBuilder::table);
    let path = folder.join("report.html");
    page.playback(&robot.character, &evaluation.playbacks()).write(&path)?;
    Ok(path)
}

/// Returns the tables for people, and the verdicts in one line at their end: all falls and more measures are in the report.
pub fn text(evaluation: &Evaluation) -> String {
    let more = screen().wide.then(|| evaluation.root_table());
    let tables = [evaluation.table()].into_iter().chain(evaluation.fall_summary()).chain(more);
    let tables: String = tables.map(|table| fitted(&table) + "\n").collect();
    tables + &summary(evaluation.clips.iter().map(|clip| &clip.verdict)) + "\n"
}
