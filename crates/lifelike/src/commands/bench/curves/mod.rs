//! `lifelike bench curves`: the Spline-based Transformer and its baselines on curves (thesis 3.3.1, Table 3.1; 3.3.5).

mod budget;
mod page;
mod results;
mod tables;

use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Instant;

use lifelike_learn::representation::spline_transformer::{
    CurveSequences, CurvesPlan, Family, HeldOut, Method, SequenceTrainer, run as folders,
};
use lifelike_nn::device::Device;
use serde_json::json;
use tracing::info;

use crate::commands::train::hardware::Networks;
use crate::error::CliError;
use crate::output::Output;
use crate::progress::Progress;
use crate::{interrupt, overrides};
use budget::Budget;
use results::Run;

/// Train the Spline-based Transformer and its baselines on families of plane curves, and print thesis Table 3.1 with ours below it.
///
/// Methods of one family meet the same curves in the same order, with the same settings. Errors are mean squared errors of (x, y) over
/// test curves (10,000 but for the smoke budget) that no run is ever trained on. Each run has its folder; the same command goes on
/// with what was stopped and leaves alone what is done. The folder gets curves.json and report.html: the loss of validation against
/// iterations and time, and test curves with their reconstructions.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike bench curves --budget smoke -o runs/smoke                                   # a minute: does it work at all?
  lifelike bench curves -o runs/curves                                                 # a smaller batch than the thesis'
  lifelike bench curves --families bezier-2 --methods spline,alibi --iterations 500 -o runs/bezier
  lifelike bench curves --budget thesis --families lissajous --minutes 60 -o runs/long # an hour each; again for another hour
  lifelike bench curves --families lissajous --methods spline --rates 1e-4,1e-3,1e-2 --warmup 200 -o runs/rates
  lifelike bench curves -o runs/other training.batch=64 training.max_gradient_norm=1.0

Families: lissajous, hypotrochoids, bezier-2, bezier-64. Methods: spline, alibi, alibi-cat.
With --rates the learning rate is swept (thesis 3.3.5, Fig. 3.7b); --warmup N then adds the same rates with a linear rise over N
iterations to compare with, and without --rates it applies to all runs.")]
pub struct Args {
    /// Families of curves; all where not given.
    #[arg(long, value_delimiter = ',')]
    families: Vec<Family>,
    /// Methods; all where not given.
    #[arg(long, value_delimiter = ',')]
    methods: Vec<Method>,
    /// How long, and how large a batch.
    #[arg(long, value_enum, default_value_t)]
    budget: Budget,
    /// Iterations of each run, instead of the budget's; the learning rate falls to 0 over them.
    #[arg(long)]
    iterations: Option<u64>,
    /// Stop each run after so many minutes, done or not; the same command goes on with it.
    #[arg(long)]
    minutes: Option<f64>,
    /// Learning rates to sweep, instead of the thesis' one.
    #[arg(long, value_delimiter = ',')]
    rates: Vec<f64>,
    /// Iterations over which the learning rate rises.
    #[arg(long)]
    warmup: Option<u64>,
    /// Key of weights and training curves.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Folder of the runs, of curves.json and of report.html.
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    networks: Networks,
    /// Changes to the plan of all runs, by dotted path.
    #[arg(value_name = "KEY=VALUE")]
    overrides: Vec<String>,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    if let Some(minutes) = args.minutes.filter(|m| !(m.is_finite() && *m > 0.0)) {
        return Err(CliError::Usage(format!("--minutes: expected a number above 0, got {minutes}")));
    }
    let plans = plans(args)?;
    let device = args.networks.open()?;
    let mut runs = Vec::new();
    for (name, plan) in &plans {
        let folder = args.output.join(name);
        info!("{name}: {}", folder.display());
        let trainer = trained(plan, &folder, &device, args, output)?;
        runs.push(Run::of(plan, &trainer, &folder)?);
        save(args, &runs)?;
    }
    let report = args.output.join("report.html");
    output.result(&value(args, &runs), || {
        let tables: String =
            tables::all(&runs, sweeps(args)).iter().map(|t| t.to_text() + &t.caption + "\n\n").collect();
        format!("{tables}report: {}\n", report.display())
    })
}

fn sweeps(args: &Args) -> bool {
    !args.rates.is_empty()
}

/// Every run's folder name and plan, checked before the first begins.
fn plans(args: &Args) -> Result<Vec<(String, CurvesPlan)>, CliError> {
    let chosen = |none: bool, here: bool| none || here;
    let families = Family::ALL.into_iter().filter(|f| chosen(args.families.is_empty(), args.families.contains(f)));
    let rates: Vec<Option<f64>> =
        if sweeps(args) { args.rates.iter().map(|rate| Some(*rate)).collect() } else { vec![None] };
    // A sweep compares with and without; a plain run has what it is told.
    let warmups: BTreeSet<u64> = match args.warmup {
        Some(warmup) if sweeps(args) => [0, warmup].into(),
        other => [other.unwrap_or(0)].into(),
    };
    let mut plans = Vec::new();
    for family in families {
        for method in Method::ALL.into_iter().filter(|m| chosen(args.methods.is_empty(), args.methods.contains(m))) {
            for rate in &rates {
                for warmup in &warmups {
                    let mut plan = args.budget.plan(family);
                    let training = &mut plan.training;
                    (training.method, training.seed, training.warmup) = (method, args.seed, *warmup);
                    training.iterations = args.iterations.unwrap_or(training.iterations);
                    training.learning_rate = rate.unwrap_or(training.learning_rate);
                    let plan: CurvesPlan = overrides::apply(plan, &args.overrides)?;
                    plan.check()?;
                    let rate = rate.map_or(String::new(), |rate| format!("-rate-{rate:e}"));
                    let rise = if *warmup > 0 { format!("-warmup-{warmup}") } else { String::new() };
                    plans.push((format!("{family}-{method}{rate}{rise}-{}", args.seed), plan));
                }
            }
        }
    }
    Ok(plans)
}

/// Trains until the plan is done or the minutes are over. Ctrl-C ends the command.
fn trained(
    plan: &CurvesPlan,
    folder: &Path,
    device: &Device,
    args: &Args,
    output: &Output,
) -> Result<SequenceTrainer<CurveSequences>, CliError> {
    let stop = interrupt::flag()?;
    let total = plan.training.iterations;
    let mut progress = Progress::new(output, "training", total);
    let (began, mut interrupted) = (Instant::now(), false);
    let data = CurveSequences::new(plan)?;
    let trainer = folders::train(folder, plan, &plan.training, data, device, |now| {
        progress.update(now.iteration, total, || format!("{} {} {:.2e}", plan.family, plan.training.method, now.loss));
        interrupted = stop.load(Ordering::SeqCst);
        let late = args.minutes.is_some_and(|minutes| began.elapsed().as_secs_f64() > 60.0 * minutes);
        if interrupted || late { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    progress.finish();
    if interrupted {
        return Err(CliError::Interrupted("the same command goes on".into()));
    }
    Ok(trainer)
}

fn value(args: &Args, runs: &[Run]) -> serde_json::Value {
    json!({ "budget": args.budget.name(), "thesis": tables::thesis(), "runs": runs })
}

/// Writes curves.json and report.html.
fn save(args: &Args, runs: &[Run]) -> Result<(), CliError> {
    let text = serde_json::to_string_pretty(&value(args, runs)).map_err(|e| CliError::Failed(e.to_string()))?;
    let file = args.output.join("curves.json");
    std::fs::write(&file, text).map_err(CliError::write(&file))?;
    Ok(page::report(runs, args.budget, sweeps(args)).write(&args.output.join("report.html"))?)
}

/// Errors of test curves.
const TABLE: HeldOut = HeldOut::Test;
