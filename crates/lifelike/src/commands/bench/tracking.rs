//! `lifelike bench tracking`: variants of one plan, trained and evaluated alike (thesis Tables 4.3 and 4.4).

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_evaluation::{Chain, ClipScore, CommonErrors, EpisodeScore, EvaluationOptions, on_common_frames};
use lifelike_report::run::{RunFolder, read_metrics};
use lifelike_report::{Cell, Column, Table};
use lifelike_robot::{ControllerFile, Robot};
use lifelike_tracking::{TrackerPlan, Trainer};
use serde::{Deserialize, Serialize};
use tracing::info;

use crate::commands::controller_file::Loaded;
use crate::commands::physics;
use crate::commands::train::hardware::Hardware;
use crate::commands::{clips, eval, train};
use crate::error::CliError;
use crate::output::Output;
use crate::plans;

/// Train variants of one plan with several seeds, evaluate all on the same motion, and print them as one table.
///
/// A study is a TOML file: the plan that all have in common, the variants as changes to it, and classes of clips. Each run
/// has its folder; what is there already is not trained again, and a run that was stopped goes on.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike bench tracking --study experiments/study-inputs.toml -o runs/inputs          # thesis Table 4.3
  lifelike bench tracking --study study-thesis -o runs/thesis                            # the same in the thesis' own form
  lifelike bench tracking --study study-thesis -o runs/thesis --starts 5                 # each clip from five places
  lifelike bench tracking --study experiments/study-inputs.toml -o runs/try budget.steps=200000
  lifelike bench tracking --study experiments/study-inputs.toml -o runs/inputs --only M,LM --json | jq .runs

The first table has errors over the frames before a fall with survival beside them, the second errors over the frames that all policies
of the table survive. A study that says `episodes` is evaluated as the thesis does: episodes of `seconds` that go from clip to clip.")]
pub struct Args {
    /// The study: a file, or a built-in one by its name.
    #[arg(long)]
    study: PathBuf,
    /// Folder of the runs and of tracking.json.
    #[arg(short, long)]
    output: PathBuf,
    /// Train only these variants; others stand in the table where they are trained already.
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
    /// Evaluate so many episodes of each clip, from starts spread evenly, in place of the study's own protocol.
    #[arg(long)]
    starts: Option<usize>,
    #[command(flatten)]
    hardware: Hardware,
    /// Changes to the plan of all variants, by dotted path.
    #[arg(value_name = "KEY=VALUE")]
    overrides: Vec<String>,
}

/// A comparison: the common plan, its variants, and classes of clips.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Study {
    /// The plan that all variants have in common.
    plan: PathBuf,
    /// Changes to the plan of all variants, as on the command line.
    #[serde(default)]
    set: Vec<String>,
    variant: Vec<Variant>,
    class: Vec<Class>,
    /// Rows from elsewhere to stand above ours.
    #[serde(default)]
    published: Vec<Published>,
    /// Episodes per clip.
    #[serde(default = "five")]
    starts: usize,
    /// In place of `starts`: episodes of one length for each class, that go from clip to clip (thesis 4.3.3).
    #[serde(default)]
    episodes: Option<usize>,
    /// Longest episode, or the length of all `episodes` (s).
    #[serde(default = "ten")]
    seconds: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Variant {
    name: String,
    seeds: Vec<u64>,
    /// Changes to the plan, as on the command line.
    #[serde(default)]
    set: Vec<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Class {
    name: String,
    clips: Vec<PathBuf>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Published {
    name: String,
    /// Joint error (deg) and end-effector error (m) by class.
    errors: BTreeMap<String, [f64; 2]>,
}

impl Study {
    /// Checks the extent of its evaluations; `file` is where it was read from.
    fn check(&self, file: &Path) -> Result<(), CliError> {
        for (key, value) in [("starts", Some(self.starts)), ("episodes", self.episodes)] {
            if let Some(value) = value.filter(|value| !(1..=eval::STARTS).contains(value)) {
                let text = format!("{}: expected {key} from 1 to {}, got {value}", file.display(), eval::STARTS);
                return Err(CliError::Input(text));
            }
        }
        if !(self.seconds > 0.0 && self.seconds <= 3600.0) {
            let text = format!("{}: expected seconds above 0 and at most 3600, got {}", file.display(), self.seconds);
            return Err(CliError::Input(text));
        }
        Ok(())
    }
}

fn five() -> usize {
    5
}

fn ten() -> f64 {
    10.0
}

/// One trained policy, evaluated.
#[derive(Debug, Serialize)]
struct Run {
    variant: String,
    seed: u64,
    steps: u64,
    minutes: f64,
    /// By class, in the study's order.
    scores: Vec<ClipScore>,
    /// By class, over the frames that every run of the table survives.
    common: Vec<CommonErrors>,
    #[serde(skip)]
    episodes: Vec<Vec<EpisodeScore>>,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    physics::available(&args.hardware.physics.engine)?;
    if train::processes::count() > 1 {
        return Err(CliError::Usage("start a study as one process".into()));
    }
    let mut study = read(&args.study)?;
    if let Some(starts) = args.starts {
        (study.starts, study.episodes) = (starts, None);
    }
    study.check(&args.study)?;
    if let Some(unknown) = args.only.iter().find(|name| !study.variant.iter().any(|v| v.name == **name)) {
        let known: Vec<&str> = study.variant.iter().map(|v| v.name.as_str()).collect();
        return Err(CliError::Usage(format!("--only: expected some of {}, got '{unknown}'", known.join(", "))));
    }
    let mut runs = Vec::new();
    for variant in &study.variant {
        let wanted = args.only.is_empty() || args.only.contains(&variant.name);
        for &seed in &variant.seeds {
            let changes = study.set.iter().chain(&variant.set).chain(&args.overrides).cloned();
            let changes: Vec<String> = changes.chain([format!("seed={seed}")]).collect();
            let plan: TrackerPlan = plans::load(&study.plan, &changes)?;
            let folder = args.output.join(format!("{}-{seed}", variant.name));
            // What others have trained before belongs into the table all the same.
            if !wanted && !is_trained(&plan, &folder)? {
                continue;
            }
            info!("{} with seed {seed}: {}", variant.name, folder.display());
            trained(&plan, &folder, args, output)?;
            runs.push(evaluated(&study, &variant.name, &plan, &folder, args, output)?);
            compare(&study, &mut runs)?;
            save(&runs, &args.output)?;
        }
    }
    output.result(&runs, || format!("{}\n{}", table(&study, &runs).to_text(), common_table(&study, &runs).to_text()))
}

/// Finds the errors over the frames that all runs so far survive.
fn compare(study: &Study, runs: &mut [Run]) -> Result<(), CliError> {
    runs.iter_mut().for_each(|run| run.common.clear());
    for class in 0..study.class.len() {
        let episodes: Vec<&[EpisodeScore]> = runs.iter().map(|run| run.episodes[class].as_slice()).collect();
        let common = on_common_frames(&episodes)?;
        runs.iter_mut().zip(common).for_each(|(run, errors)| run.common.push(errors));
    }
    Ok(())
}

fn read(path: &Path) -> Result<Study, CliError> {
    let plans::PlanText { source, text, folder } = plans::find(path)?;
    let mut study: Study = toml::from_str(&text).map_err(|e| CliError::Input(format!("{source}: {e}")))?;
    if let Some(folder) = folder {
        study.plan = plans::located(&study.plan, &folder);
    }
    Ok(study)
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
    let Some(summary) = train::tracker::train(plan, folder, exists, &args.hardware, output)? else {
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
    variant: &str,
    plan: &TrackerPlan,
    folder: &Path,
    args: &Args,
    output: &Output,
) -> Result<Run, CliError> {
    let robot = Arc::new(Robot::load(&plan.robot)?);
    let loaded = Loaded::new(&policy_of(folder), Arc::clone(&robot), plan.prior.as_deref())?;
    let job = eval::Job { loaded: &loaded, physics: &args.hardware.physics };
    let chain = study.episodes.map(|episodes| Chain { episodes, seed: 1 });
    let (starts, seconds) = (study.starts, study.seconds);
    let options = EvaluationOptions { starts, seconds, chain, keep: 0, ..EvaluationOptions::default() };
    let (mut scores, mut episodes) = (Vec::new(), Vec::new());
    for class in &study.class {
        let clips = clips::load(&class.clips, &robot)?;
        let evaluation = job.run(&clips, &options, output)?;
        scores.push(ClipScore { clip: class.name.clone(), ..evaluation.overall });
        episodes.push(evaluation.episodes);
    }
    let (steps, minutes) = (loaded.controller.header().provenance.steps, minutes_of(folder)?);
    Ok(Run { variant: variant.into(), seed: plan.seed, steps, minutes, scores, common: Vec::new(), episodes })
}

fn save(runs: &[Run], folder: &Path) -> Result<(), CliError> {
    let file = folder.join("tracking.json");
    let text = serde_json::to_string_pretty(runs).map_err(|e| CliError::Failed(e.to_string()))?;
    std::fs::write(&file, text).map_err(CliError::write(&file))
}

/// Joint error | end-effector error | survival by class, below what others publish; with several seeds the mean, and ± half
/// the range.
fn table(study: &Study, runs: &[Run]) -> Table {
    let mut table =
        by_class("Tracking errors by class of motion", "deg | m | survival %", study, runs, |own, class| {
            let of = |value: fn(&ClipScore) -> f64| spread(own.iter().map(|r| value(&r.scores[class])));
            let (joints, effectors) = (of(|s| s.joint_error_deg), of(|s| s.effector_error_m));
            format!("{} | {} | {}", say(joints, 2), say(effectors, 3), say(of(|s| 100.0 * s.survival), 0))
        });
    let published = |row: &Published, class: &Class| {
        let errors = row.errors.get(&class.name);
        errors.map_or("–".into(), |[d, m]| format!("{} | {}", say((*d, 0.0), 2), say((*m, 0.0), 3)))
    };
    let above = study.published.iter().map(|row| {
        let cells = study.class.iter().map(|class| published(row, class));
        [row.name.clone(), String::new()].into_iter().chain(cells).map(Cell::text).collect()
    });
    table.rows.splice(0..0, above);
    table
}

/// The same over the frames that every run survives, and the share of all frames that these are.
fn common_table(study: &Study, runs: &[Run]) -> Table {
    let title = "Over the frames that every run of the table survives";
    by_class(title, "deg | m | frames %", study, runs, |own, class| {
        let of = |value: fn(&CommonErrors) -> f64| spread(own.iter().map(|r| value(&r.common[class])));
        let (joints, effectors) = (of(|c| c.joint_error_deg), of(|c| c.effector_error_m));
        format!("{} | {} | {}", say(joints, 2), say(effectors, 3), say(of(|c| 100.0 * c.covered), 0))
    })
}

/// A row for each variant that has runs, a column for each class.
fn by_class(title: &str, unit: &str, study: &Study, runs: &[Run], cell: impl Fn(&[&Run], usize) -> String) -> Table {
    let mut columns = vec![Column::text("input"), Column::number("runs", "")];
    columns.extend(study.class.iter().map(|class| Column::number(&class.name, unit)));
    let mut table = Table::new(title, columns);
    for variant in &study.variant {
        let own: Vec<&Run> = runs.iter().filter(|r| r.variant == variant.name).collect();
        if !own.is_empty() {
            let cells = (0..study.class.len()).map(|class| cell(&own, class));
            let head = [variant.name.clone(), own.len().to_string()];
            table.rows.push(head.into_iter().chain(cells).map(Cell::text).collect());
        }
    }
    table
}

/// Mean and half the range.
fn spread(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = values.clone().count() as f64;
    let (low, high) = values.clone().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    (values.sum::<f64>() / n, 0.5 * (high - low))
}

fn say((mean, half_range): (f64, f64), digits: usize) -> String {
    if mean.is_nan() {
        // What a paper does not tell, or nothing was measured of.
        "–".into()
    } else if half_range > 0.0 {
        format!("{mean:.digits$} ± {half_range:.digits$}")
    } else {
        format!("{mean:.digits$}")
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::overrides;

    #[test]
    fn our_own_studies_can_be_read_and_every_variant_is_a_plan() {
        let mut count = 0;
        for builtin in plans::builtin().filter(|plan| plan.name.starts_with("study-")) {
            let path = Path::new(builtin.name);
            let study = read(path).unwrap();
            let common: TrackerPlan = toml::from_str(&plans::find(&study.plan).unwrap().text).unwrap();
            for variant in &study.variant {
                let changes: Vec<String> = study.set.iter().chain(&variant.set).cloned().collect();
                let plan = overrides::apply(common.clone(), &changes).unwrap();
                plan.check().unwrap();
                assert!(!variant.seeds.is_empty(), "{}: {}", path.display(), variant.name);
            }
            for row in &study.published {
                let known = |class: &String| study.class.iter().any(|c| c.name == *class);
                assert!(row.errors.keys().all(known), "{}: {}", path.display(), row.name);
            }
            count += 1;
        }
        assert!(count > 0);
    }

    #[test]
    fn spread_by_hand() {
        assert_eq!(spread([1.0, 2.0, 6.0].into_iter()), (3.0, 2.5));
        assert_eq!(say((3.0, 2.5), 1), "3.0 ± 2.5");
        assert_eq!(say((3.0, 0.0), 2), "3.00");
        assert_eq!(say((f64::NAN, f64::NAN), 2), "–");
    }
}
