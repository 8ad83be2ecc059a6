//! The thesis' convolutional beta-VAE as the prior.

use lifelike_motion::FeatureLayout;
use lifelike_representation::prior::vae::{VaePlan, VaeTrainer};

use super::{Job, Trained};
use crate::error::CliError;

/// Trains until the plan is done or Ctrl-C.
pub fn train(plan: &VaePlan, layout: &FeatureLayout, job: Job<'_>) -> Result<Trained, CliError> {
    let trainer = VaeTrainer::new(plan.clone(), layout.clone(), job.training, job.held_out)?;
    let mut trainer = trainer.to_device(&job.device);
    let summary = job.driver.train(&mut trainer, |now| {
        format!("reconstruction {:.3}  KL {:.1}", now.metrics.reconstruction, now.metrics.kl)
    })?;
    let (prior, report) = (trainer.prior(), trainer.report()?);
    let parameters = trainer.parameters();
    Ok(Trained { prior, report, iterations: summary.iteration, parameters, interrupted: summary.interrupted })
}
