//! The Spline-based Transformer as the prior: its run is that of any sequence autoencoder.

use std::ops::ControlFlow;
use std::sync::atomic::Ordering;

use lifelike_learn::representation::spline_prior::{SplinePriorPlan, WindowSequences, prior_of};
use lifelike_learn::representation::spline_transformer::run;
use lifelike_motion::FeatureLayout;

use super::{Job, Trained};
use crate::error::CliError;
use crate::interrupt;
use crate::output::Output;
use crate::progress::Progress;

/// Trains until the plan is done or Ctrl-C.
pub fn train(
    plan: &SplinePriorPlan,
    layout: &FeatureLayout,
    job: Job<'_>,
    output: &Output,
) -> Result<Trained, CliError> {
    let training = &plan.training;
    let data = WindowSequences::new(plan.windows, training.seed, layout.clone(), job.training, job.held_out)?;
    let stop = interrupt::flag()?;
    let mut progress = Progress::new(output, "training", training.iterations);
    let mut interrupted = false;
    let trainer = run::train(job.folder, job.plan, training, data, &job.device, |now| {
        progress.update(now.iteration, training.iterations, || format!("mean squared error {:.4}", now.loss));
        interrupted = stop.load(Ordering::SeqCst);
        if interrupted { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    progress.finish();
    let prior = prior_of(&trainer)?;
    let report = prior.reconstruct(trainer.data().watched())?;
    let (iterations, parameters) = (trainer.iteration(), trainer.parameters());
    Ok(Trained { prior, report, iterations, parameters, interrupted })
}
