//! The β-VAE as a kind of prior: a code is the mean of the encoder's normal distribution.

use burn::tensor::{Tensor, TensorData};
use lifelike_checkpoint::Checkpoint;
use lifelike_nn::ModuleCheckpoint;
use lifelike_nn::device::{self, Device};
use lifelike_nn::numbers::read;

use super::network::{MotionVae, NETWORK};
use super::plan::VaePlan;
use super::train::VaeTrainer;
use crate::RepresentationError;
use crate::components::Components;
use crate::prior::kind::{PriorData, PriorKind};

impl PriorKind for MotionVae {
    const NAME: &'static str = "motion prior";
    const TABLE: &'static str = "prior";
    const TITLE: &'static str = "a beta-VAE";
    type Plan = VaePlan;
    type Trainer = VaeTrainer;

    fn trainer(plan: &VaePlan, data: PriorData, device: &Device) -> Result<VaeTrainer, RepresentationError> {
        Ok(VaeTrainer::new(plan.clone(), data.layout, data.training, data.held_out)?.to_device(device))
    }

    fn encode(&self, windows: Vec<f32>, [samples, features]: [usize; 2]) -> Result<Vec<f32>, RepresentationError> {
        let shape = [windows.len() / (samples * features), samples, features];
        let x = Tensor::<3>::from_data(TensorData::new(windows, shape), &device::inference());
        Ok(read(MotionVae::encode(self, x).0)?)
    }

    fn decode(&self, codes: &[f32], _: usize) -> Result<Vec<f32>, RepresentationError> {
        let latent = self.latent_size();
        let z = TensorData::new(codes.to_vec(), [codes.len() / latent, latent]);
        Ok(read(MotionVae::decode(self, Tensor::<2>::from_data(z, &device::inference())))?)
    }

    fn save_into(&self, checkpoint: &mut Checkpoint) -> Result<(), RepresentationError> {
        checkpoint.put_module(NETWORK, self)?;
        self.linear_path().map_or(Ok(()), |components| components.save_into(checkpoint))
    }

    fn load_from(plan: &VaePlan, checkpoint: &Checkpoint, features: usize) -> Result<Self, RepresentationError> {
        let network = checkpoint.load_module(NETWORK, Self::new(plan, features, &device::inference()))?;
        if !plan.linear_path {
            return Ok(network);
        }
        let size = plan.windows.window().len() * features;
        Ok(network.with_linear_path(Components::read(checkpoint, plan.latent, size)?))
    }
}
