//! Principal components as a kind of motion prior.

use lifelike_checkpoint::Checkpoint;

use super::plan::PcaPlan;
use super::train::PcaTrainer;
use crate::RepresentationError;
use crate::components::Components;
use crate::prior::kind::{PriorData, PriorKind};

impl PriorKind for Components {
    const NAME: &'static str = "principal components of motion";
    const TITLE: &'static str = "principal components";
    type Plan = PcaPlan;
    type Trainer = PcaTrainer;

    fn trainer(plan: &PcaPlan, data: PriorData) -> Result<PcaTrainer, RepresentationError> {
        PcaTrainer::new(*plan, data)
    }

    fn encode(&self, windows: Vec<f32>, _: [usize; 2]) -> Result<Vec<f32>, RepresentationError> {
        Ok(Self::encode(self, &windows))
    }

    fn decode(&self, codes: &[f32], _: usize) -> Result<Vec<f32>, RepresentationError> {
        Ok(Self::decode(self, codes))
    }

    fn save_into(&self, checkpoint: &mut Checkpoint) -> Result<(), RepresentationError> {
        Self::save_into(self, checkpoint)
    }

    fn load_from(plan: &PcaPlan, checkpoint: &Checkpoint, features: usize) -> Result<Self, RepresentationError> {
        Self::read(checkpoint, plan.latent, plan.windows.window().len() * features)
    }
}
