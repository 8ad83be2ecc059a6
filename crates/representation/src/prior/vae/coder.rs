//! The β-VAE as a kind of prior: a code is the mean of the encoder's normal distribution.

use lifelike_checkpoint::Checkpoint;
use rayon::prelude::*;

use super::network::{MotionVae, NETWORK};
use super::plan::VaePlan;
use super::train::VaeTrainer;
use crate::RepresentationError;
use crate::components::Components;
use crate::prior::kind::{PriorData, PriorKind};

/// Windows that a core takes at a time.
const PART: usize = 64;

impl PriorKind for MotionVae {
    const NAME: &'static str = "motion prior";
    const TITLE: &'static str = "a beta-VAE";
    type Plan = VaePlan;
    type Trainer = VaeTrainer;

    fn trainer(plan: &VaePlan, data: PriorData) -> Result<VaeTrainer, RepresentationError> {
        VaeTrainer::new(plan.clone(), data.layout, data.training, data.held_out)
    }

    fn encode(&self, windows: Vec<f32>, [samples, features]: [usize; 2]) -> Result<Vec<f32>, RepresentationError> {
        let weights = self.weights();
        let parts = windows.par_chunks(PART * samples * features).map(|part| weights.encode(part).0.mean);
        Ok(parts.collect::<Vec<_>>().concat())
    }

    fn decode(&self, codes: &[f32], _: usize) -> Result<Vec<f32>, RepresentationError> {
        let weights = self.weights();
        let parts = codes.par_chunks(PART * self.latent_size()).map(|part| weights.decode(part.to_vec()).0);
        Ok(parts.collect::<Vec<_>>().concat())
    }

    fn save_into(&self, checkpoint: &mut Checkpoint) -> Result<(), RepresentationError> {
        self.parameters().save_into(checkpoint, NETWORK)?;
        self.linear_path().map_or(Ok(()), |components| components.save_into(checkpoint))
    }

    fn load_from(plan: &VaePlan, checkpoint: &Checkpoint, features: usize) -> Result<Self, RepresentationError> {
        let mut network = Self::new(plan, features);
        *network.parameters_mut() = network.parameters().load_from(checkpoint, NETWORK)?;
        if !plan.linear_path {
            return Ok(network);
        }
        let size = plan.windows.window().len() * features;
        Ok(network.with_linear_path(Components::read(checkpoint, plan.latent, size)?))
    }
}
