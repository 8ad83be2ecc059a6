//! `lifelike eval`: how well a policy follows.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use lifelike_evaluation::explain::{self, Explanation};
use lifelike_evaluation::verdict::summary;
use lifelike_evaluation::{Evaluation, EvaluationOptions, ThesisEvaluation, ThesisProtocol, thesis_tables};
use lifelike_motion::{MotionClip, container, feasibility};
use lifelike_report::{ReportBuilder, Table};
use lifelike_robot::Robot;

use crate::commands::clips;
use crate::commands::controller_file::Loaded;
use crate::commands::families::Families;
use crate::commands::motion::container_in;
use crate::commands::physics::{self, Physics};
use crate::error::CliError;
use crate::next::{self, NextCommand};
use crate::output::{Output, fitted, screen};
use crate::progress::Progress;

/// Most episodes of one clip: more is a mistake.
pub const STARTS: usize = 10_000;

/// Evaluate a policy in physics: errors, survival, where and why it fell.
///
/// Every clip is followed from several frames of it, without noise. The folder gets evaluation.json and report.html,
/// which plays physics beside the reference. With --protocol thesis, episodes of one length begin at random frames, and errors
/// count in all of their frames (thesis 4.3.3 and 5.3.3). docs/evaluation.md defines every measure.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike eval --policy lima --motions builtin -o report
  lifelike eval --policy runs/walk --motions data/lima -o report
  lifelike eval --policy mine.controller.safetensors --motions a.bvh b.bvh -o report
  lifelike eval --policy runs/walk --motions @experiments/track-20-test.txt -o report
  lifelike eval --policy runs/walk --motions data/lima -o report \\
      --json | jq .overall.survival
  lifelike eval --policy runs/walk --motions kept/MDM --protocol thesis \\
      --episodes 2048 -o report
  lifelike eval --policy runs/walk --motions data/g1 \\
      --families experiments/families.txt -o report
  lifelike eval --policy runs/walk --motions data/lima -o report \\
      --explain --apply data/repaired
  lifelike eval --policy lima --motions builtin -o report --mcap    # for Foxglove and rerun

Motions may be *.motion.safetensors, or captured motion and keyframes, which are retargeted on the way.")]
pub struct Args {
    /// The controller: a name, a file, or the folder of a run.
    #[arg(short, long)]
    pub policy: PathBuf,
    /// The spline prior that the policy was trained with, where it was; other priors are in the controller.
    #[arg(long)]
    pub prior: Option<PathBuf>,
    /// The robot: a name, or an MJCF or URDF file; what the policy was trained for where not given.
    #[arg(short, long)]
    pub robot: Option<String>,
    /// Clips to follow: files, folders, patterns, or @list.txt with one of them per line.
    #[arg(short, long, required = true, num_args = 1..)]
    pub motions: Vec<PathBuf>,
    /// Layout of the motion.
    #[command(flatten)]
    pub layout: clips::LayoutArgument,
    /// Folder of the results.
    #[arg(short, long, value_parser = crate::destination::folder)]
    pub output: PathBuf,
    /// clips: episodes on every clip, which end with a fall. thesis: episodes of one length, errors over all frames.
    #[arg(long, value_enum, default_value_t = Protocol::Clips)]
    pub protocol: Protocol,
    /// Longest episode, 10 where not given; with --protocol thesis the length of all, 30 (s).
    #[arg(long)]
    pub seconds: Option<f64>,
    /// Episodes per clip, from frames spread over it.
    #[arg(long, default_value_t = 5)]
    pub starts: usize,
    /// Extent of --protocol thesis.
    #[command(flatten)]
    pub thesis: ThesisArgs,
    /// File of families of clips, a row each in the tables: lines of a name and patterns of clip names.
    #[arg(long, value_name = "FILE")]
    pub families: Option<PathBuf>,
    /// Give every frame the latent code of another one, drawn by this seed: what a policy loses by it is what it gets from codes.
    #[arg(long, value_name = "SEED")]
    pub permute_codes: Option<u64>,
    /// Say of every clip that it falls on why, and try which change of the clip would help.
    #[arg(long)]
    pub explain: bool,
    /// Write the clips that a change helps to this folder, changed.
    #[arg(long, value_name = "FOLDER", requires = "explain")]
    pub apply: Option<PathBuf>,
    /// Write an MCAP file for each recorded clip, for Foxglove, rerun and rosbag2: joints, bodies, contacts, torques.
    #[arg(long, visible_alias = "rerun")]
    pub mcap: bool,
    /// Engine and threads.
    #[command(flatten)]
    pub physics: Physics,
}

impl Args {
    /// Returns a subcommand with the same policy on the same clips.
    fn again(&self, subcommand: &str) -> NextCommand {
        let line = NextCommand::new(subcommand).path("--policy", &self.policy);
        let line = self.robot.iter().fold(line, |line, robot| line.robot(robot));
        let line = self.prior.iter().fold(line, |line, prior| line.path("--prior", prior));
        line.motions(&self.motions)
    }

    /// Returns the step after this evaluation: the reasons for falls, else how much the policy withstands.
    fn next(&self, falls: bool) -> NextCommand {
        let folder = |name: &str| self.output.join(name);
        if falls && !self.explain {
            return self.again("eval").word("--explain").path("-o", &folder("explained"));
        }
        self.again("bench robustness").word("--quick").path("-o", &folder("robustness"))
    }
}

/// Protocol of an evaluation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum, serde::Deserialize, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Protocol {
    /// Episodes on every clip that end with a fall.
    Clips,
    /// The thesis': episodes of one length, errors over all frames.
    Thesis,
}

/// Extent and termination of the thesis' protocol, as options.
#[derive(Debug, clap::Args)]
pub struct ThesisArgs {
    /// Episodes of --protocol thesis [default: 200].
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub episodes: Option<u64>,
    /// End-effector deviation without consequence, t^p; the robot's (thesis Table 4.1) where not given (m).
    #[arg(long, value_name = "METRES")]
    pub deviation: Option<f64>,
    /// Longest time above it, f [default: 3] (s).
    #[arg(long, value_name = "SECONDS")]
    pub patience: Option<f64>,
    /// Random seed of the frames of --protocol thesis [default: 1].
    #[arg(long)]
    pub seed: Option<u64>,
}

impl ThesisArgs {
    /// Returns the protocol; its numbers must be in their ranges.
    pub fn protocol(&self, seconds: Option<f64>) -> Result<ThesisProtocol, CliError> {
        let otherwise = ThesisProtocol::default();
        let protocol = ThesisProtocol {
            episodes: self.episodes.map_or(otherwise.episodes, |n| n as usize),
            seconds: seconds.unwrap_or(otherwise.seconds),
            distance: self.deviation,
            patience: self.patience.unwrap_or(otherwise.patience),
            seed: self.seed.unwrap_or(otherwise.seed),
        };
        checked(&protocol).map_err(CliError::Usage)?;
        Ok(protocol)
    }

    fn any(&self) -> bool {
        self.episodes.is_some() || self.deviation.is_some() || self.patience.is_some() || self.seed.is_some()
    }
}

/// Checks the numbers of the thesis' protocol.
pub fn checked(protocol: &ThesisProtocol) -> Result<(), String> {
    let within = |name: &str, value: f64, most: f64| {
        let good = value > 0.0 && value <= most;
        if good { Ok(()) } else { Err(format!("{name}: expected above 0 and at most {most}, got {value}")) }
    };
    within("episodes", protocol.episodes as f64, 1e6)?;
    within("seconds", protocol.seconds, 3600.0)?;
    within("patience", protocol.patience, 3600.0)?;
    protocol.distance.map_or(Ok(()), |distance| within("deviation", distance, 100.0))
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    physics::available(&args.physics.engine)?;
    let by_thesis = args.protocol == Protocol::Thesis;
    if args.thesis.any() && !by_thesis {
        let text = "--episodes, --deviation, --patience and --seed: expected --protocol thesis beside them";
        return Err(CliError::Usage(text.into()));
    }
    if by_thesis && (args.explain || args.families.is_some() || args.permute_codes.is_some() || args.mcap) {
        let text = "--explain, --families, --permute-codes and --mcap: expected --protocol clips";
        return Err(CliError::Usage(text.into()));
    }
    let seconds = args.seconds.unwrap_or(10.0);
    if !(seconds > 0.0 && seconds <= 3600.0 && (1..=STARTS).contains(&args.starts)) {
        let text = format!("--seconds must be above 0 and at most 3600, --starts from 1 to {STARTS}");
        return Err(CliError::Usage(text));
    }
    let loaded = Loaded::load(&args.policy, args.robot.as_deref(), args.prior.as_deref())?;
    let robot = loaded.controller.robot();
    args.physics.require_ready(robot)?;
    let clips = clips::load_as(&args.motions, args.layout, robot)?;
    let job = Job { loaded: &loaded, physics: &args.physics };
    let title = format!("{} on {} clips", args.policy.display(), clips.len());
    if by_thesis {
        let found = job.thesis(&clips, &args.thesis.protocol(args.seconds)?, output)?;
        let report = save_thesis(&found, &title, &args.output)?;
        let next = [args.again("eval").path("-o", &args.output)];
        return output
            .result(&found, || format!("{}report: {}\n{}", thesis_text(&found), report.display(), next::lines(&next)));
    }
    let families = args.families.as_deref().map(Families::read).transpose()?;
    let options = EvaluationOptions {
        seconds,
        starts: args.starts,
        permute_codes: args.permute_codes,
        ..EvaluationOptions::default()
    };
    let mut evaluation = job.run(&clips, &options, output)?;
    by_feasibility(&mut evaluation, &clips, robot)?;
    if let Some(families) = families {
        families.group(&mut evaluation);
    }
    let explanations = args.explain.then(|| job.explain(&evaluation, &clips, &options, output)).transpose()?;
    let table = explanations.as_ref().and_then(|all| explain::table(all));
    let report = save(&evaluation, table, robot, &title, &args.output)?;
    if args.mcap {
        for rollout in &evaluation.rollouts {
            let file = crate::destination::named(&args.output, &rollout.clip, ".mcap")?;
            crate::output::write(&file, lifelike_evaluation::mcap(rollout, robot)?)?;
        }
    }
    for repaired in explanations.iter().flatten().filter_map(|e| e.repaired.as_ref()) {
        let Some(folder) = &args.apply else { break };
        container::write(&container_in(folder, &repaired.name)?, repaired)?;
    }
    let sentences: String = explanations.iter().flatten().map(|e| e.words() + "\n").collect();
    let result = Explained { evaluation: &evaluation, explanations };
    let next = args.next(evaluation.clips.iter().any(|clip| clip.survival < 1.0));
    output.result(&result, || {
        format!("{sentences}{}report: {}\n{}", text(&evaluation), report.display(), next::lines(&[next]))
    })
}

/// Adds what comes of clips that can be tracked, as far as can be told without physics, and of others, apart.
fn by_feasibility(evaluation: &mut Evaluation, clips: &[MotionClip], robot: &Robot) -> Result<(), CliError> {
    let mut trackable = BTreeMap::new();
    for clip in clips {
        let found = feasibility::check(clip, &robot.character, &robot.anatomy, &robot.speeds())?;
        trackable.insert(clip.name.as_str(), found.trackable);
    }
    let is = |name: &str, wanted: bool| trackable.get(name).is_some_and(|own| *own == wanted);
    evaluation.group("trackable", |name| is(name, true));
    evaluation.group("untrackable", |name| is(name, false));
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

    /// Evaluates on clips by the thesis' protocol.
    pub fn thesis(
        &self,
        clips: &[MotionClip],
        protocol: &ThesisProtocol,
        output: &Output,
    ) -> Result<ThesisEvaluation, CliError> {
        let simulate = |terrain, n| self.physics.simulate(terrain, self.loaded.controller.robot(), n);
        let mut progress = Progress::new(output, "evaluating", protocol.episodes as u64);
        let found = self.loaded.setup(&simulate).evaluate_thesis(clips, protocol, |done, of| {
            progress.update(done as u64, of as u64, String::new);
        })?;
        progress.finish();
        Ok(found)
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
    write_json(evaluation, folder)?;
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

/// Writes `evaluation.json` and `report.html` of an evaluation by the thesis' protocol; returns the report's path.
fn save_thesis(found: &ThesisEvaluation, title: &str, folder: &Path) -> Result<PathBuf, CliError> {
    write_json(found, folder)?;
    let page = ReportBuilder::new(title)
        .subtitle("Fixed-length episodes that begin at random frames; errors over all of their frames.")
        .fact("robot", found.robot.clone())
        .fact("engine", found.engine.clone())
        .fact("protocol", protocol_words(&found.protocol));
    let page = thesis_tables([("all", &found.errors)]).into_iter().fold(page, ReportBuilder::table);
    let path = folder.join("report.html");
    page.write(&path)?;
    Ok(path)
}

fn write_json(result: &impl serde::Serialize, folder: &Path) -> Result<(), CliError> {
    std::fs::create_dir_all(folder).map_err(CliError::write(folder))?;
    crate::output::write_json(&folder.join("evaluation.json"), result)
}

/// Returns the protocol in a line.
pub fn protocol_words(protocol: &ThesisProtocol) -> String {
    let ThesisProtocol { episodes, seconds, patience, seed, .. } = protocol;
    let distance = protocol.distance.map_or("the robot's".into(), |distance| format!("{distance} m"));
    format!("{episodes} episodes of {seconds} s, t^p {distance} for {patience} s, seed {seed}")
}

fn thesis_text(found: &ThesisEvaluation) -> String {
    let tables = thesis_tables([("all", &found.errors)]);
    let tables: String = tables.iter().map(|table| format!("{}\n{}\n", table.title, fitted(table))).collect();
    format!("{} clips, {}\n\n{tables}", found.clips, protocol_words(&found.protocol))
}

/// Returns the tables for people, and the verdicts in one line at their end: all falls and more measures are in the report.
pub fn text(evaluation: &Evaluation) -> String {
    let by_group = screen().wide || !evaluation.groups.is_empty();
    let more = by_group.then(|| evaluation.group_tables()).into_iter().flatten();
    let tables = [evaluation.table()].into_iter().chain(evaluation.fall_summary()).chain(more);
    let tables: String = tables.map(|table| fitted(&table) + "\n").collect();
    tables + &summary(evaluation.clips.iter().map(|clip| &clip.verdict)) + "\n"
}
