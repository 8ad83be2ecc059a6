//! `lifelike-thesis critic`: is what a critic predicts what happens, and does it tell which motion falls?

mod episodes;
mod page;
mod predictors;

use std::path::PathBuf;

use lifelike_generation::critic::calibration::{auc, bootstrap, spearman};
use lifelike_generation::critic::{Critic, CriticTrainer};
use lifelike_report::run::RunFolder;
use lifelike_report::{Cell, Column, Table};
use lifelike_tracking::plan::EpisodeSpec;
use serde::Serialize;

use self::episodes::{Fate, measured, of_clips, of_episodes};
use self::predictors::{Predictor, predictors};
use lifelike::CliError;
use lifelike::Output;
use lifelike::commands::clips;
use lifelike::commands::controller_file::Loaded;
use lifelike::commands::physics::Physics;
use lifelike::commands::rollouts::{Rollouts, digest_of, environment_of, rows_of};
use lifelike::commands::train::critic::CriticTrainingPlan;

/// Measure a critic on motion that it did not learn from: predicted values beside returns in physics, and which episodes fall.
///
/// Two kinds of episodes, all with the randomisation and pushes of training: from random frames, and from the start of every
/// clip. Beside the critic stand a ridge regression on plain kinematics, which learned from the same records, and the findings of
/// `lifelike motion check`. Intervals are 95% of a bootstrap over clips.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike-thesis critic --run runs/critic --motions @experiments/track-all-test.txt -o critic
  lifelike-thesis --json critic --run runs/critic --motions data/mine | jq .ranking")]
pub struct Args {
    /// Folder of the critic's run.
    #[arg(long)]
    run: PathBuf,
    /// Clips to measure on: files, folders, patterns, or @list.txt with one of them per line.
    #[arg(short, long, required = true, num_args = 1..)]
    motions: Vec<PathBuf>,
    /// Environments that begin at random frames.
    #[arg(long, default_value_t = 256, value_parser = lifelike::bounds::environments)]
    environments: usize,
    /// Control steps of each.
    #[arg(long, default_value_t = 1500)]
    steps: u64,
    /// Longest episode from a random frame (s).
    #[arg(long, default_value_t = 5.0)]
    seconds: f64,
    /// Episodes from the start of each clip.
    #[arg(long, default_value_t = 8)]
    repeats: usize,
    /// Key of everything random.
    #[arg(long, default_value_t = 7)]
    seed: u64,
    /// Folder for critic.json and report.html.
    #[arg(short, long, value_parser = lifelike::destination::folder)]
    output: Option<PathBuf>,
    /// Engine and threads.
    #[command(flatten)]
    physics: Physics,
}

/// A number with its 95% interval.
#[derive(Debug, Clone, Copy, Serialize)]
struct Interval {
    value: f64,
    low: f64,
    high: f64,
}

impl Interval {
    /// Returns a statistic of samples in groups.
    fn of(groups: &[usize], seed: u64, statistic: impl Fn(&[usize]) -> f64) -> Self {
        let all: Vec<usize> = (0..groups.len()).collect();
        let [low, high] = bootstrap(groups, seed, &statistic);
        Self { value: statistic(&all), low, high }
    }

    fn cell(&self) -> Cell {
        if self.value.is_nan() {
            return Cell::text("-");
        }
        Cell { value: Some(self.value), ..Cell::text(format!("{:.3} ({:.3}..{:.3})", self.value, self.low, self.high)) }
    }
}

/// One predictor's marks.
#[derive(Debug, Serialize)]
struct Marks {
    predictor: &'static str,
    /// Rank correlation with measured returns, window by window.
    windows: Interval,
    /// The same of the means of clips.
    clips: Interval,
    /// AUC of falling, episodes from random frames.
    episodes: Interval,
    /// The same, episodes from clip starts.
    starts: Interval,
    /// AUC of clips of whose episodes from the start at least half fall.
    falling_clips: Interval,
}

/// Everything measured.
#[derive(Debug, Serialize)]
struct Measured {
    clips: usize,
    windows: usize,
    explained_variance: f64,
    episodes: usize,
    episodes_that_fell: usize,
    starts: usize,
    starts_that_fell: usize,
    clips_that_fell: usize,
    ranking: Vec<Marks>,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let plan: CriticTrainingPlan = RunFolder::open(&args.run)?.plan()?;
    let critic = Critic::load(&CriticTrainer::critic_path(&args.run))?;
    let digest = digest_of(&plan.controller)?;
    if digest != critic.header().controller {
        let path = plan.controller.display();
        return Err(CliError::Input(format!(
            "{path}: expected the critic's controller {}, got {digest}",
            critic.header().controller
        )));
    }
    let loaded = Loaded::load(&plan.controller, Some(&plan.robot), None)?;
    let robot = loaded.controller.robot();
    args.physics.require_ready(robot)?;
    let motions = clips::load(&args.motions, robot)?;
    let predictors = predictors(critic, &plan, &args.run, &motions, robot)?;
    let environment = plan.environment.as_deref();
    let tracker = environment_of(environment, &plan.controller, &loaded.controller, &plan.robot, args.seed)?;
    let rollouts =
        Rollouts { controller: &loaded.controller, clips: &motions, tracker: &tracker, physics: &args.physics };
    let random = EpisodeSpec { seconds: args.seconds, switch_clips: false, ..tracker.episode };
    let random = rollouts.record(rollouts.environment(random, args.environments)?, args.steps, output)?;
    let starts = episodes::from_starts(&rollouts, args.repeats, output)?;

    let (_, rows) = rows_of(&motions, robot)?;
    let windows = measured(&random, &rows, plan.critic.gamma);
    let fates = [of_episodes(&random, &rows, args.seconds), of_episodes(&starts, &rows, f64::INFINITY)];
    let fallen = of_clips(&fates[1], motions.len());
    let marks = |predictor: &Predictor| {
        let of_window: Vec<f64> = windows.iter().map(|w| predictor.at(w.clip, w.row)).collect();
        let returns: Vec<f64> = windows.iter().map(|w| w.value).collect();
        let groups: Vec<usize> = windows.iter().map(|w| w.clip).collect();
        let pick = |x: &[f64], samples: &[usize]| samples.iter().map(|i| x[*i]).collect::<Vec<_>>();
        let correlation = |s: &[usize]| spearman(&pick(&of_window, s), &pick(&returns, s));
        let by_clip = |x: &[f64]| episodes::means(x, &groups, motions.len());
        let (clip_predicted, clip_returns) = (by_clip(&of_window), by_clip(&returns));
        let present: Vec<usize> = (0..motions.len()).filter(|c| !clip_returns[*c].is_nan()).collect();
        let of_clips = |s: &[usize]| {
            let clips = pick_index(&present, s);
            spearman(&pick(&clip_predicted, &clips), &pick(&clip_returns, &clips))
        };
        let own: Vec<usize> = (0..present.len()).collect();
        let falls = |fates: &[Fate]| {
            // The less is promised, the sooner it falls.
            let scores: Vec<f64> = fates.iter().map(|f| -predictor.over(f.clip, f.rows.clone())).collect();
            let groups: Vec<usize> = fates.iter().map(|f| f.clip).collect();
            Interval::of(&groups, args.seed, |s| {
                auc(&pick(&scores, s), &s.iter().map(|i| fates[*i].fell).collect::<Vec<_>>())
            })
        };
        Marks {
            predictor: predictor.name,
            windows: Interval::of(&groups, args.seed, correlation),
            clips: Interval::of(&own, args.seed, of_clips),
            episodes: falls(&fates[0]),
            starts: falls(&fates[1]),
            falling_clips: falls(&fallen),
        }
    };
    let predicted: Vec<f64> = windows.iter().map(|w| predictors[0].at(w.clip, w.row)).collect();
    let count = |fates: &[Fate]| fates.iter().filter(|f| f.fell).count();
    let result = Measured {
        clips: motions.len(),
        windows: windows.len(),
        explained_variance: episodes::explained(&windows, &predicted),
        episodes: fates[0].len(),
        episodes_that_fell: count(&fates[0]),
        starts: fates[1].len(),
        starts_that_fell: count(&fates[1]),
        clips_that_fell: count(&fallen),
        ranking: predictors.iter().map(marks).collect(),
    };
    let table = table(&result);
    if let Some(folder) = &args.output {
        page::save(folder, &result, &table, &windows, &predicted)?;
    }
    output.result(&result, || format!("{}\n{}\n{}\n", table.title, lifelike::output::fitted(&table), table.caption))
}

fn pick_index(from: &[usize], at: &[usize]) -> Vec<usize> {
    at.iter().map(|i| from[*i]).collect()
}

fn table(m: &Measured) -> Table {
    let numbers = ["rank, windows", "rank, clips", "AUC, random frames", "AUC, clip starts", "AUC, clips"];
    let columns = [Column::text("predictor")].into_iter().chain(numbers.map(|name| Column::number(name, "")));
    let mut table = Table::new("A critic on motion that it did not learn from", columns.collect());
    table.rows = m
        .ranking
        .iter()
        .map(|marks| {
            let numbers = [&marks.windows, &marks.clips, &marks.episodes, &marks.starts, &marks.falling_clips];
            [Cell::text(marks.predictor)].into_iter().chain(numbers.map(Interval::cell)).collect()
        })
        .collect();
    table.caption = format!(
        "Higher is better. Rank: Spearman correlation of predicted value and measured discounted return over {} windows and \
         {} clips. AUC: telling what falls from what does not, of {} episodes from random frames ({} fell), {} from clip \
         starts ({} fell), and of clips of which at least half of the episodes from the start fell ({}). In brackets 95% of a \
         bootstrap over clips. The critic explains {:.2} of the variance of the windows' mean returns.",
        m.windows,
        m.clips,
        m.episodes,
        m.episodes_that_fell,
        m.starts,
        m.starts_that_fell,
        m.clips_that_fell,
        m.explained_variance
    );
    table
}
