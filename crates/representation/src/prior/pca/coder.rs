//! Windows to principal components and back.

use burn::tensor::{Tensor, TensorData};
use lifelike_checkpoint::Checkpoint;
use lifelike_nn::device::{self, Device};
use lifelike_nn::numbers::read;

use super::plan::PcaPlan;
use super::train::PcaTrainer;
use crate::RepresentationError;
use crate::prior::kind::{PriorData, PriorKind};

/// The mean window, and directions from it, each as long as the standard deviation of the training windows along it.
#[derive(Debug, Clone)]
pub struct Components {
    mean: Vec<f32>,
    /// Orthogonal rows, largest first: `[d_z, samples · features]`.
    directions: Vec<f32>,
    latent: usize,
}

impl Components {
    /// `directions` are unit rows; `deviations` is the standard deviation of the data along each.
    pub(super) fn new(mean: Vec<f32>, directions: &[f32], deviations: &[f64]) -> Self {
        let rows = directions.chunks_exact(mean.len()).zip(deviations);
        let directions = rows.flat_map(|(row, s)| row.iter().map(move |x| x * *s as f32)).collect();
        Self { mean, directions, latent: deviations.len() }
    }

    /// Reads what [`Self::save_into`] wrote, for windows of `size` numbers.
    pub(in crate::prior) fn read(
        checkpoint: &Checkpoint,
        latent: usize,
        size: usize,
    ) -> Result<Self, RepresentationError> {
        let mean = checkpoint.f32s(MEAN, &[size])?;
        let directions = checkpoint.f32s(DIRECTIONS, &[latent, size])?;
        Ok(Self { mean, directions, latent })
    }

    /// Returns the components of windows, in standard deviations.
    ///
    /// # Shapes
    /// `[N, samples · features]` to `[N, d_z]`.
    pub(in crate::prior) fn codes(&self, windows: Tensor<2>) -> Tensor<2> {
        let (rows, mean) = self.tensors(&windows.device());
        // x · row / |row|² is the component in standard deviations.
        let squares = rows.clone().square().sum_dim(1).clamp_min(f32::MIN_POSITIVE).swap_dims(0, 1);
        (windows - mean).matmul(rows.swap_dims(0, 1)) / squares
    }

    /// Returns the windows that components stand for.
    ///
    /// # Shapes
    /// `[N, d_z]` to `[N, samples · features]`.
    pub(in crate::prior) fn windows(&self, codes: Tensor<2>) -> Tensor<2> {
        let (rows, mean) = self.tensors(&codes.device());
        codes.matmul(rows) + mean
    }

    /// Directions `[d_z, samples · features]` and the mean `[1, samples · features]`.
    fn tensors(&self, device: &Device) -> (Tensor<2>, Tensor<2>) {
        let size = self.mean.len();
        let rows = TensorData::new(self.directions.clone(), [self.latent, size]);
        let mean = TensorData::new(self.mean.clone(), [1, size]);
        (Tensor::from_data(rows, device), Tensor::from_data(mean, device))
    }
}

/// Names in files.
const MEAN: &str = "components.mean";
const DIRECTIONS: &str = "components.directions";

impl PriorKind for Components {
    const NAME: &'static str = "principal components of motion";
    const TABLE: &'static str = "pca";
    const TITLE: &'static str = "principal components";
    type Plan = PcaPlan;
    type Trainer = PcaTrainer;

    fn trainer(plan: &PcaPlan, data: PriorData, _: &Device) -> Result<PcaTrainer, RepresentationError> {
        PcaTrainer::new(*plan, data)
    }

    fn encode(&self, windows: Vec<f32>, _: [usize; 2]) -> Result<Vec<f32>, RepresentationError> {
        let shape = [windows.len() / self.mean.len(), self.mean.len()];
        Ok(read(self.codes(Tensor::from_data(TensorData::new(windows, shape), &device::inference())))?)
    }

    fn decode(&self, codes: &[f32], _: usize) -> Result<Vec<f32>, RepresentationError> {
        let z = TensorData::new(codes.to_vec(), [codes.len() / self.latent, self.latent]);
        Ok(read(self.windows(Tensor::from_data(z, &device::inference())))?)
    }

    fn save_into(&self, checkpoint: &mut Checkpoint) -> Result<(), RepresentationError> {
        checkpoint.put_f32(MEAN, &[self.mean.len()], self.mean.clone())?;
        Ok(checkpoint.put_f32(DIRECTIONS, &[self.latent, self.mean.len()], self.directions.clone())?)
    }

    fn load_from(plan: &PcaPlan, checkpoint: &Checkpoint, features: usize) -> Result<Self, RepresentationError> {
        Self::read(checkpoint, plan.latent, plan.windows.window().len() * features)
    }
}
