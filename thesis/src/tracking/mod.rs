//! `lifelike-thesis tracking`: variants of one plan, trained and evaluated alike (thesis Tables 4.3 and 4.4).

mod curves;
mod study;
mod tables;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_evaluation::{ClipScore, EvaluationOptions, ThesisErrors, ThesisProtocol};
use lifelike_report::ReportBuilder;
use lifelike_report::run::{RunFolder, read_metrics};
use lifelike_robot::{ControllerFile, Robot};
use lifelike_tracking::{TrackerPlan, Trainer};
use serde::Serialize;
use tracing::info;

use lifelike::CliError;
use lifelike::Output;
use lifelike::commands::controller_file::Loaded;
use lifelike::commands::physics;
use lifelike::commands::physics::Physics;
use lifelike::commands::train::source::Source;
use lifelike::commands::{clips, eval, train};
use lifelike::plans;
use study::{Job, Study};

/// Train variants of one plan with several seeds, evaluate all on the same motion, and print them as one table.
///
/// A study is a TOML file: the plan that all have in common, the variants as changes to it, and classes of clips. It may have stages:
/// trainings of each variant one after the other, each beginning with the networks of the one before. Each run has its folder; what
/// is there already is not trained again, and a run that was stopped goes on.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  # thesis Tables 4.3 and 4.4, in a checkout
  lifelike-thesis tracking --study thesis/experiments/study-thesis.toml -o runs/thesis
  # each clip from five places, one seed of every variant
  lifelike-thesis tracking --study study.toml -o runs/thesis --starts 5 --seeds 2
  lifelike-thesis tracking --study study.toml -o runs/thesis --only M,LM --json | jq .runs
  lifelike-thesis tracking --study study.toml -o runs/try budget.steps=200000

The same policies are evaluated by two protocols (`protocol = \"clips\", \"thesis\" or \"both\"` in the study). Ours has errors over the
frames before a fall, with survival and the share of the reference's steps that are taken beside them. The thesis' has errors over all
frames of fixed-length episodes ([thesis] in the study). tracking.json has every number, report.html the learning curves.")]
pub struct Args {
    /// The study: a TOML file such as those of thesis/experiments.
    #[arg(long)]
    study: PathBuf,
    /// Folder of the runs, of tracking.json and report.html.
    #[arg(short, long, value_parser = lifelike::destination::folder)]
    output: PathBuf,
    /// Train only these variants, then evaluate others too that are trained already.
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
    /// Seeds of every variant, in place of the study's own: one replicate of the whole at a time.
    #[arg(long, value_delimiter = ',')]
    seeds: Vec<u64>,
    /// Episodes of each clip by our own protocol, in place of the study's number.
    #[arg(long)]
    starts: Option<usize>,
    #[command(flatten)]
    physics: Physics,
    /// Changes to the plan of all variants, by dotted path.
    #[arg(value_name = "KEY=VALUE")]
    overrides: Vec<String>,
}

/// One trained policy, evaluated.
#[derive(Debug, Serialize)]
struct Run {
    variant: String,
    /// Stage of its training, where the study has several.
    #[serde(skip_serializing_if = "Option::is_none")]
    stage: Option<String>,
    seed: u64,
    steps: u64,
    minutes: f64,
    /// Our protocol, by class in the study's order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    scores: Vec<ClipScore>,
    /// The thesis' protocol, likewise.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    thesis: Vec<ThesisErrors>,
    /// End-effector deviation at which the thesis' protocol terminates (m).
    #[serde(skip_serializing_if = "Option::is_none")]
    deviation: Option<f64>,
    /// Path of the study's file.
    #[serde(skip)]
    place: usize,
}

/// Everything that a study found.
#[derive(Debug, Serialize)]
struct Results<'a> {
    study: &'a Path,
    plan: &'a Path,
    classes: Vec<&'a str>,
    starts: usize,
    seconds: f64,
    thesis: &'a ThesisProtocol,
    runs: &'a [Run],
    curves: Vec<curves::SeedCurve>,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    physics::available(&args.physics.engine)?;
    if train::processes::count() > 1 {
        return Err(CliError::Usage("start a study as one process".into()));
    }
    let mut study = study::read(&args.study)?;
    if let Some(starts) = args.starts {
        study.starts = starts;
    }
    study.check(&args.study)?;
    if let Some(twice) = study::named_twice(&args.seeds) {
        return Err(CliError::Usage(format!("--seeds: expected every seed once, got {twice} twice")));
    }
    if !args.seeds.is_empty() {
        study.variant.iter_mut().for_each(|variant| variant.seeds.clone_from(&args.seeds));
    }
    if let Some(unknown) = args.only.iter().find(|name| !study.variant.iter().any(|v| v.name == **name)) {
        let known: Vec<&str> = study.variant.iter().map(|v| v.name.as_str()).collect();
        return Err(CliError::Usage(format!("--only: expected some of {}, got '{unknown}'", known.join(", "))));
    }
    let wanted = |job: &Job| args.only.is_empty() || args.only.contains(&job.variant);
    let jobs = study.jobs();
    let (first, others): (Vec<_>, Vec<_>) = jobs.iter().cloned().partition(wanted);
    let mut runs = Vec::new();
    for job in first.into_iter().chain(others) {
        let folder = args.output.join(&job.folder);
        // What others have trained before belongs into the table all the same; of what they have not begun there may be no plan yet, as the
        // stage that it begins with is missing.
        let wanted = wanted(&job);
        if !wanted && !policy_of(&folder).exists() {
            continue;
        }
        let plan = plan_of(&study, &job, args)?;
        if !wanted && !is_trained(&plan, &folder)? {
            continue;
        }
        info!("{} with seed {}: {}", job.variant, job.seed, folder.display());
        trained(&plan, &folder, args, output)?;
        runs.push(evaluated(&study, &job, &plan, &folder, args, output)?);
        runs.sort_by_key(|run: &Run| run.place);
        save(&results(&study, &jobs, &runs, args)?, &study, &args.output)?;
    }
    output.result(&results(&study, &jobs, &runs, args)?, || tables::text(&study, &runs))
}

fn results<'a>(study: &'a Study, jobs: &[Job], runs: &'a [Run], args: &'a Args) -> Result<Results<'a>, CliError> {
    Ok(Results {
        study: &args.study,
        plan: &study.plan,
        classes: study.class.iter().map(|class| class.name.as_str()).collect(),
        starts: study.starts,
        seconds: study.seconds,
        thesis: &study.thesis,
        runs,
        curves: curves::of(study, jobs, &args.output)?,
    })
}

/// Returns the plan of a training.
fn plan_of(study: &Study, job: &Job, args: &Args) -> Result<TrackerPlan, CliError> {
    let beginning = job.begins_with.as_ref().map(|folder| format!("init={}", args.output.join(folder).display()));
    let changes = job.changes.iter().chain(&args.overrides).cloned();
    let changes: Vec<String> = changes.chain([format!("seed={}", job.seed)]).chain(beginning).collect();
    plans::load(&study.plan, &changes)
}

/// Trains what is not trained yet. A folder of another plan is refused.
fn trained(plan: &TrackerPlan, folder: &Path, args: &Args, output: &Output) -> Result<(), CliError> {
    let exists = folder.join("plan.toml").exists();
    if exists {
        let there: TrackerPlan = RunFolder::open(folder)?.plan()?;
        if there != *plan {
            let text = format!("{}: expected a run of this variant's plan, got one of another", folder.display());
            return Err(CliError::Input(text));
        }
        if is_trained(plan, folder)? {
            return Ok(());
        }
    }
    let Some(summary) =
        train::tracker::train(plan, folder, &Source { resume: exists, ..Source::default() }, &args.physics, output)?
    else {
        return Err(CliError::Usage("start a study as one process".into()));
    };
    if summary.interrupted {
        return Err(CliError::Interrupted("the same command goes on".into()));
    }
    Ok(())
}

/// Returns whether a run's policy is that of its whole budget: a run that goes on has one too.
fn is_trained(plan: &TrackerPlan, folder: &Path) -> Result<bool, CliError> {
    let policy = policy_of(folder);
    if !policy.exists() {
        return Ok(false);
    }
    let steps = ControllerFile::read(&policy)?.header().provenance.steps;
    let spent = plan.budget.minutes.map_or(Ok(false), |minutes| minutes_of(folder).map(|spent| spent >= minutes));
    Ok(steps >= plan.budget.steps || spent?)
}

/// Wall time of a run so far (min); NaN where it has not said yet.
fn minutes_of(folder: &Path) -> Result<f64, CliError> {
    let timing = read_metrics(&RunFolder::open(folder)?.timing_path())?;
    let last = timing.last().and_then(|row| row.values.iter().find(|(name, _)| name == "Perf/wall_time"));
    Ok(last.map_or(f64::NAN, |(_, seconds)| seconds / 60.0))
}

fn policy_of(folder: &Path) -> PathBuf {
    Trainer::policy_path(folder)
}

fn evaluated(
    study: &Study,
    job: &Job,
    plan: &TrackerPlan,
    folder: &Path,
    args: &Args,
    output: &Output,
) -> Result<Run, CliError> {
    let robot = Arc::new(Robot::load(&plan.robot)?);
    let loaded = Loaded::new(&policy_of(folder), Arc::clone(&robot), plan.prior.as_deref())?;
    let evaluation = eval::Job { loaded: &loaded, physics: &args.physics };
    let (starts, seconds) = (study.starts, study.seconds);
    let options = EvaluationOptions { starts, seconds, keep: 0, ..EvaluationOptions::default() };
    let protocol = ThesisProtocol { distance: deviation(study, plan, &robot)?, ..study.thesis.clone() };
    let (mut scores, mut thesis, mut deviation) = (Vec::new(), Vec::new(), None);
    let (by_clips, by_thesis) = study.protocols();
    for class in &study.class {
        let clips = clips::load(&class.clips, &robot)?;
        if by_clips {
            let found = evaluation.run(&clips, &options, output)?;
            scores.push(ClipScore { clip: class.name.clone(), ..found.overall });
        }
        if by_thesis {
            let found = evaluation.thesis(&clips, &protocol, output)?;
            thesis.push(found.errors);
            deviation = found.protocol.distance;
        }
    }
    let (steps, minutes) = (loaded.controller.header().provenance.steps, minutes_of(folder)?);
    let (variant, stage, place) = (job.variant.clone(), job.stage.clone(), job.place);
    Ok(Run { variant, stage, seed: plan.seed, steps, minutes, scores, thesis, deviation, place })
}

/// Returns t^p of an evaluation: the study's, or the plan's, scaled to the robot; none for the robot's own.
fn deviation(study: &Study, plan: &TrackerPlan, robot: &Robot) -> Result<Option<f64>, CliError> {
    let of_plan = plan.scaled_to(robot)?.termination.persistent.map(|rule| f64::from(rule.distance));
    Ok(study.thesis.distance.or(of_plan))
}

/// Writes tracking.json, and report.html with the tables and learning curves.
fn save(results: &Results<'_>, study: &Study, folder: &Path) -> Result<(), CliError> {
    let file = folder.join("tracking.json");
    lifelike::output::write_json(&file, results)?;
    let page = ReportBuilder::new("Variants of one plan")
        .subtitle("Each trained and evaluated alike; learning curves with the range over seeds.")
        .fact("runs", results.runs.len().to_string());
    let page = tables::all(study, results.runs).into_iter().fold(page, ReportBuilder::table);
    let page = curves::charts(study, &results.curves).into_iter().fold(page, ReportBuilder::chart);
    Ok(page.write(&folder.join("report.html"))?)
}
