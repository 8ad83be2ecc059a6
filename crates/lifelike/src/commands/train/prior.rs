//! `lifelike train prior`: a latent code for the second of motion around every frame.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use lifelike_learn::representation::dataset::split;
use lifelike_learn::representation::{PriorClip, PriorPlan, PriorTrainer, ReconstructionReport};
use lifelike_learn::run::{MetricsWriter, RunFolder};
use lifelike_robot::Robot;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::hardware::Networks;
use super::run_folder;
use crate::commands::reconstruction::{self, HEAD, row};
use crate::commands::{clips, prior_file};
use crate::error::CliError;
use crate::output::{Output, table};
use crate::progress::Progress;
use crate::{interrupt, overrides};

/// Iterations between checkpoints.
const SAVE_EVERY: u64 = 200;

/// Train a motion prior: a convolutional beta-VAE over one second of motion (thesis 4.2.1).
///
/// The run is a folder: plan.toml, metrics.jsonl, TensorBoard events, checkpoint.safetensors, and at the end
/// motion.prior.safetensors. Ctrl-C saves and stops; --resume goes on as if nothing had happened.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike train prior --plan experiments/prior.toml
  lifelike train prior --plan experiments/prior.toml -o runs/small prior.channels=32 prior.iterations=1000
  lifelike train prior -o runs/small --resume

A plan names robot and clips, and under [prior] whatever differs from the thesis' settings.")]
pub struct Args {
    /// The plan, a TOML file; with --resume the run's own plan is used.
    #[arg(long)]
    pub plan: Option<PathBuf>,
    /// The run's folder; runs/ and the plan's name where not given.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Go on with the run in the folder.
    #[arg(long)]
    pub resume: bool,
    #[command(flatten)]
    pub networks: Networks,
    /// Changes to the plan, by dotted path.
    #[arg(value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
}

/// What to train on what.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Plan {
    /// A built-in robot's name, or its MJCF or URDF file.
    robot: String,
    /// Clips: files, folders, patterns. Captured motion and keyframes are retargeted to the robot.
    clips: Vec<PathBuf>,
    /// The prior.
    #[serde(default)]
    prior: PriorPlan,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let folder = run_folder(args.output.as_deref(), args.plan.as_deref())?;
    let plan: Plan = match (&args.plan, args.resume) {
        (_, true) if args.overrides.is_empty() => RunFolder::open(&folder)?.plan()?,
        (_, true) => return Err(CliError::Usage("a prior's run goes on with the plan it was started with".into())),
        (Some(path), false) => overrides::load(path, &args.overrides)?,
        (None, false) => return Err(CliError::Usage("say what to train with --plan FILE".into())),
    };
    plan.prior.check()?;
    let robot = Robot::load(&plan.robot)?;
    let (training, held_out) =
        split(&plan.prior, prior_file::frames(&clips::load(&plan.clips, &robot)?, &robot, plan.prior.frame_rate)?);
    let names = |clips: &[PriorClip]| clips.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
    let (trained_on, held_out_names) = (names(&training), names(&held_out));
    let checkpoint = folder.join("checkpoint.safetensors");
    let run = if args.resume { RunFolder::open(&folder)? } else { RunFolder::create(&folder, &plan)? };
    let device = args.networks.open()?;
    let trainer = if args.resume && checkpoint.is_file() {
        PriorTrainer::resume(&checkpoint, training, held_out)?
    } else {
        PriorTrainer::new(plan.prior.clone(), robot.layout.clone(), training, held_out)?
    };
    let mut trainer = trainer.to_device(&device);
    let mut metrics =
        run.resume_metrics(lines_until(&run.metrics_path(), trainer.iteration())?, trainer.iteration())?;
    let interrupted = train(&mut trainer, &mut metrics, &checkpoint, output)?;
    let path = folder.join("motion.prior.safetensors");
    trainer.prior().save(&path)?;
    let report = trainer.report()?;
    let value = json!({
        "run": folder, "prior": path, "interrupted": interrupted, "iterations": trainer.iteration(),
        "parameters": trainer.parameters(), "trained_on": trained_on, "held_out": held_out_names,
        "reconstruction": reconstruction::value(&report),
    });
    let text = serde_json::to_string_pretty(&value).map_err(|e| CliError::Failed(e.to_string()))?;
    let file = folder.join("reconstruction.json");
    std::fs::write(&file, text).map_err(CliError::write(&file))?;
    output.result(&value, || {
        format!(
            "{} iterations, {} parameters, {} clips; reconstruction of {} windows of {}:\n\n{}\nprior: {}\n",
            trainer.iteration(),
            trainer.parameters(),
            trained_on.len(),
            report.windows,
            if held_out_names.is_empty() { "the training clips" } else { "clips never trained on" },
            reconstruction_table(&report),
            path.display()
        )
    })?;
    if interrupted {
        return Err(CliError::Interrupted(format!("go on with --resume -o {}", folder.display())));
    }
    Ok(())
}

/// Iterates until the plan is done or Ctrl-C; returns whether it was Ctrl-C.
fn train(
    trainer: &mut PriorTrainer,
    metrics: &mut MetricsWriter,
    checkpoint: &Path,
    output: &Output,
) -> Result<bool, CliError> {
    let stop = interrupt::flag()?;
    let total = trainer.plan().iterations;
    let mut progress = Progress::new(output, "training", total);
    let mut failed = None;
    let mut interrupted = false;
    trainer.train(|trainer, now| {
        progress.update(now.iteration, total, || format!("reconstruction {:.3}  KL {:.1}", now.reconstruction, now.kl));
        let values = [
            ("Loss/total", now.loss),
            ("Loss/reconstruction", now.reconstruction),
            ("Loss/kl", now.kl),
            ("Schedule/kl_weight", now.kl_weight),
            ("Schedule/learning_rate", now.learning_rate),
            ("Gradient/norm", now.gradient_norm),
            ("Gradient/skipped", now.skipped as f64),
        ];
        let mut done = metrics.log(now.iteration - 1, &values);
        interrupted = stop.load(Ordering::SeqCst);
        if done.is_ok() && (interrupted || now.iteration == total || now.iteration % SAVE_EVERY == 0) {
            done = metrics.sync().and_then(|_| trainer.save(checkpoint));
        }
        let ends = interrupted || done.is_err();
        failed = done.err();
        if ends { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    progress.finish();
    failed.map_or(Ok(interrupted), |error| Err(error.into()))
}

/// Bytes of the metrics' lines for iterations before `iteration`: what a checkpoint made then remembers.
fn lines_until(path: &Path, iteration: u64) -> Result<u64, CliError> {
    if iteration == 0 {
        return Ok(0);
    }
    let text = std::fs::read(path).map_err(|e| CliError::Input(format!("{}: {e}", path.display())))?;
    let lines = text.split_inclusive(|b| *b == b'\n').take(usize::try_from(iteration).unwrap_or(usize::MAX));
    Ok(lines.map(|line| line.len() as u64).sum())
}

fn reconstruction_table(report: &ReconstructionReport) -> String {
    let all = [row("whole windows", &report.window), row("their centres", &report.centre)];
    let rows: Vec<Vec<String>> = all.into_iter().chain(report.clips.iter().map(|(name, e)| row(name, e))).collect();
    table(&HEAD, &rows)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn metrics_are_cut_where_the_checkpoint_was_made() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("metrics.jsonl");
        std::fs::write(&path, "{\"a\":1}\n{\"a\":22}\n{\"a\":333}\n{\"torn").unwrap();
        assert_eq!(lines_until(&path, 0).unwrap(), 0);
        assert_eq!(lines_until(&path, 2).unwrap(), 8 + 9);
        assert_eq!(lines_until(&path, 3).unwrap(), 8 + 9 + 10);
    }
}
