//! `lifelike bench tracking`: variants of one plan, trained and evaluated alike (thesis Tables 4.3 and 4.4).

mod study;
mod tables;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_evaluation::{Chain, ClipScore, CommonErrors, EpisodeScore, EvaluationOptions, on_common_frames};
use lifelike_report::run::{RunFolder, read_metrics};
use lifelike_robot::{ControllerFile, Robot};
use lifelike_tracking::{TrackerPlan, Trainer};
use serde::Serialize;
use tracing::info;

use crate::commands::controller_file::Loaded;
use crate::commands::physics;
use crate::commands::train::hardware::Hardware;
use crate::commands::{clips, eval, train};
use crate::error::CliError;
use crate::output::Output;
use crate::plans;
use study::{Job, Study};

/// Train variants of one plan with several seeds, evaluate all on the same motion, and print them as one table.
///
/// A study is a TOML file: the plan that all have in common, the variants as changes to it, and classes of clips. It may have stages:
/// trainings of each variant one after the other, each beginning with the networks of the one before. Each run has its folder; what
/// is there already is not trained again, and a run that was stopped goes on.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike bench tracking --study study-thesis -o runs/thesis                            # thesis Tables 4.3 and 4.4
  lifelike bench tracking --study study-thesis -o runs/thesis --starts 5                 # each clip from five places
  lifelike bench tracking --study study-thesis -o runs/thesis --only M,LM --json | jq .runs
  lifelike bench tracking --study study-thesis -o runs/thesis --seeds 2                  # one seed of every variant
  lifelike bench tracking --study mine.toml -o runs/try budget.steps=200000

The first table has errors over the frames before a fall, with survival and the share of the reference's steps that are taken beside
them; the second errors over the frames that all policies of a stage survive. A study that says `episodes` is evaluated as the thesis
does: episodes of `seconds` that go from clip to clip.")]
pub struct Args {
    /// The study: a file, or a built-in one by its name.
    #[arg(long)]
    study: PathBuf,
    /// Folder of the runs and of tracking.json.
    #[arg(short, long)]
    output: PathBuf,
    /// Train only these variants, then evaluate others too that are trained already.
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
    /// Seeds of every variant, in place of the study's own: one replicate of the whole at a time.
    #[arg(long, value_delimiter = ',')]
    seeds: Vec<u64>,
    /// Episodes of each clip, from starts spread evenly: how to evaluate in place of the study's own protocol.
    #[arg(long)]
    starts: Option<usize>,
    #[command(flatten)]
    hardware: Hardware,
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
    /// By class, in the study's order.
    scores: Vec<ClipScore>,
    /// By class, over the frames that every run of its stage survives.
    common: Vec<CommonErrors>,
    /// Where the study has it.
    #[serde(skip)]
    place: usize,
    #[serde(skip)]
    episodes: Vec<Vec<EpisodeScore>>,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    physics::available(&args.hardware.physics.engine)?;
    if train::processes::count() > 1 {
        return Err(CliError::Usage("start a study as one process".into()));
    }
    let mut study = study::read(&args.study)?;
    if let Some(starts) = args.starts {
        (study.starts, study.episodes) = (starts, None);
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
    let (first, others): (Vec<_>, Vec<_>) = study.jobs().into_iter().partition(wanted);
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
        compare(&study, &mut runs)?;
        save(&runs, &args.output)?;
    }
    output.result(&runs, || tables::all(&study, &runs))
}

/// Returns the plan of a training.
fn plan_of(study: &Study, job: &Job, args: &Args) -> Result<TrackerPlan, CliError> {
    let beginning = job.begins_with.as_ref().map(|folder| format!("init={}", args.output.join(folder).display()));
    let changes = job.changes.iter().chain(&args.overrides).cloned();
    let changes: Vec<String> = changes.chain([format!("seed={}", job.seed)]).chain(beginning).collect();
    plans::load(&study.plan, &changes)
}

/// Finds the errors over the frames that all runs of a stage so far survive.
fn compare(study: &Study, runs: &mut [Run]) -> Result<(), CliError> {
    runs.iter_mut().for_each(|run| run.common.clear());
    for stage in study.stages() {
        let name = stage.map(|stage| &stage.name);
        let mut own: Vec<&mut Run> = runs.iter_mut().filter(|run| run.stage.as_ref() == name).collect();
        for class in 0..study.class.len() {
            let episodes: Vec<&[EpisodeScore]> = own.iter().map(|run| run.episodes[class].as_slice()).collect();
            let common = on_common_frames(&episodes)?;
            own.iter_mut().zip(common).for_each(|(run, errors)| run.common.push(errors));
        }
    }
    Ok(())
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
    let Some(summary) = train::tracker::train(plan, folder, exists, false, &args.hardware, output)? else {
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
    let evaluation = eval::Job { loaded: &loaded, physics: &args.hardware.physics };
    let chain = study.episodes.map(|episodes| Chain { episodes, seed: 1 });
    let (starts, seconds) = (study.starts, study.seconds);
    let options = EvaluationOptions { starts, seconds, chain, keep: 0, ..EvaluationOptions::default() };
    let (mut scores, mut episodes) = (Vec::new(), Vec::new());
    for class in &study.class {
        let clips = clips::load(&class.clips, &robot)?;
        let found = evaluation.run(&clips, &options, output)?;
        scores.push(ClipScore { clip: class.name.clone(), ..found.overall });
        episodes.push(found.episodes);
    }
    let (steps, minutes) = (loaded.controller.header().provenance.steps, minutes_of(folder)?);
    let (variant, stage, place) = (job.variant.clone(), job.stage.clone(), job.place);
    Ok(Run { variant, stage, seed: plan.seed, steps, minutes, scores, common: Vec::new(), place, episodes })
}

fn save(runs: &[Run], folder: &Path) -> Result<(), CliError> {
    let file = folder.join("tracking.json");
    let text = serde_json::to_string_pretty(runs).map_err(|e| CliError::Failed(e.to_string()))?;
    std::fs::write(&file, text).map_err(CliError::write(&file))
}
