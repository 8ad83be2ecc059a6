//! The Spline-based Transformer as the prior: its run is that of any sequence autoencoder.

use lifelike_motion::FeatureLayout;
use lifelike_representation::MotionPrior;
use lifelike_representation::prior::spline::{SplinePriorPlan, WindowSequences};

use super::{Job, Trained};
use crate::commands::train::sequences::Training;
use crate::error::CliError;
use crate::output::Output;

/// Trains until the plan is done or Ctrl-C.
pub fn train(
    plan: &SplinePriorPlan,
    layout: &FeatureLayout,
    job: Job<'_>,
    output: &Output,
) -> Result<Trained, CliError> {
    let training = &plan.training;
    let data = WindowSequences::new(plan.windows, training.seed, layout.clone(), job.training, job.held_out)?;
    let run = Training { folder: job.folder, plan: job.plan, training, device: &job.device, minutes: None };
    let (trainer, interrupted) = run.run(data, output, |now| format!("mean squared error {:.4}", now.loss))?;
    let prior = MotionPrior::of_spline(&trainer)?;
    let report = prior.reconstruct(trainer.data().watched())?;
    let (iterations, parameters) = (trainer.iteration(), trainer.parameters());
    Ok(Trained { prior, report, iterations, parameters, interrupted })
}
