//! The thesis' convolutional beta-VAE as the prior.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::Ordering;

use lifelike_motion::FeatureLayout;
use lifelike_report::run::{MetricsWriter, RunFolder};
use lifelike_representation::RepresentationError;
use lifelike_representation::prior::vae::{VaePlan, VaeTrainer};

use super::{Job, Trained};
use crate::error::CliError;
use crate::interrupt;
use crate::output::Output;
use crate::progress::Progress;

/// Iterations between checkpoints.
const SAVE_EVERY: u64 = 200;

/// Trains until the plan is done or Ctrl-C.
pub fn train(plan: &VaePlan, layout: &FeatureLayout, job: Job<'_>, output: &Output) -> Result<Trained, CliError> {
    let checkpoint = job.folder.join("checkpoint.safetensors");
    let trainer = if job.resume && checkpoint.is_file() {
        VaeTrainer::resume(&checkpoint, job.training, job.held_out)?
    } else {
        VaeTrainer::new(plan.clone(), layout.clone(), job.training, job.held_out)?
    };
    let mut trainer = trainer.to_device(&job.device);
    let run = RunFolder::open(job.folder)?;
    let position = lines_until(&run.metrics_path(), trainer.iteration())?;
    let mut metrics = run.resume_metrics(position, trainer.iteration())?;
    let interrupted = iterate(&mut trainer, &mut metrics, &checkpoint, output)?;
    let (prior, report) = (trainer.prior(), trainer.report()?);
    let (iterations, parameters) = (trainer.iteration(), trainer.parameters());
    Ok(Trained { prior, report, iterations, parameters, interrupted })
}

/// Iterates until the plan is done or Ctrl-C; returns whether it was Ctrl-C.
fn iterate(
    trainer: &mut VaeTrainer,
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
        let mut done = metrics.log(now.iteration - 1, &values).map_err(RepresentationError::from);
        interrupted = stop.load(Ordering::SeqCst);
        if done.is_ok() && (interrupted || now.iteration == total || now.iteration % SAVE_EVERY == 0) {
            done = metrics.sync().map_err(RepresentationError::from).and_then(|_| trainer.save(checkpoint));
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
