//! The Spline-based Transformer as the prior: its run is that of any sequence autoencoder.

use lifelike_motion::FeatureLayout;
use lifelike_representation::MotionPrior;
use lifelike_representation::prior::spline::{SplinePriorPlan, WindowSequences};
use lifelike_representation::spline_transformer::SequenceTrainer;

use super::{Job, Trained};
use crate::error::CliError;

/// Trains until the plan is done or Ctrl-C.
pub fn train(plan: &SplinePriorPlan, layout: &FeatureLayout, job: Job<'_>) -> Result<Trained, CliError> {
    let training = &plan.training;
    let data = WindowSequences::new(plan.windows, training.seed, layout.clone(), job.training, job.held_out)?;
    let mut trainer = SequenceTrainer::new(training.clone(), data)?.to_device(&job.device);
    let summary = job.driver.train(&mut trainer, |now| format!("mean squared error {:.4}", now.metrics.loss))?;
    let prior = MotionPrior::of_spline(&trainer)?;
    let report = prior.reconstruct(trainer.data().watched())?;
    let parameters = trainer.parameters();
    Ok(Trained { prior, report, iterations: summary.iteration, parameters, interrupted: summary.interrupted })
}
