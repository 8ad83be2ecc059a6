//! Windows, or sequences of another kind, to principal components and back.

use burn::tensor::{Tensor, TensorData};
use lifelike_checkpoint::Checkpoint;
use lifelike_nn::device::{self, Device};
use lifelike_nn::numbers::read;

use crate::RepresentationError;

/// The mean row, and directions from it, each as long as the standard deviation of the rows along it.
#[derive(Debug, Clone)]
pub struct Components {
    mean: Vec<f32>,
    /// Orthogonal rows, largest first: `[k, size]`.
    directions: Vec<f32>,
    latent: usize,
}

/// Names in files.
const MEAN: &str = "components.mean";
const DIRECTIONS: &str = "components.directions";

impl Components {
    /// `directions` are unit rows; `deviations` is the standard deviation of the data along each.
    pub(super) fn new(mean: Vec<f32>, directions: &[f32], deviations: &[f64]) -> Self {
        let rows = directions.chunks_exact(mean.len()).zip(deviations);
        let directions = rows.flat_map(|(row, s)| row.iter().map(move |x| x * *s as f32)).collect();
        Self { mean, directions, latent: deviations.len() }
    }

    /// Returns the number of components.
    pub fn len(&self) -> usize {
        self.latent
    }

    /// Returns whether there are none: then every row is the mean.
    pub fn is_empty(&self) -> bool {
        self.latent == 0
    }

    /// Returns the mean row.
    pub fn mean(&self) -> &[f32] {
        &self.mean
    }

    /// Returns the first `count` of them alone: the best of that number.
    #[must_use]
    pub fn first(&self, count: usize) -> Self {
        let latent = count.min(self.latent);
        Self { directions: self.directions[..latent * self.mean.len()].to_vec(), latent, mean: self.mean.clone() }
    }

    /// Puts in what [`Self::read`] reads.
    pub(crate) fn save_into(&self, checkpoint: &mut Checkpoint) -> Result<(), RepresentationError> {
        checkpoint.put_f32(MEAN, &[self.mean.len()], self.mean.clone())?;
        Ok(checkpoint.put_f32(DIRECTIONS, &[self.latent, self.mean.len()], self.directions.clone())?)
    }

    /// Reads what [`Self::save_into`] wrote, for rows of `size` numbers.
    pub(crate) fn read(checkpoint: &Checkpoint, latent: usize, size: usize) -> Result<Self, RepresentationError> {
        let mean = checkpoint.f32s(MEAN, &[size])?;
        let directions = checkpoint.f32s(DIRECTIONS, &[latent, size])?;
        Ok(Self { mean, directions, latent })
    }

    /// Returns the components of rows, in standard deviations.
    ///
    /// # Shapes
    /// `[N, size]` to `[N, k]`.
    pub(crate) fn codes(&self, rows: Tensor<2>) -> Tensor<2> {
        let (directions, mean) = self.tensors(&rows.device());
        // x · row / |row|² is the component in standard deviations.
        let squares = directions.clone().square().sum_dim(1).clamp_min(f32::MIN_POSITIVE).swap_dims(0, 1);
        (rows - mean).matmul(directions.swap_dims(0, 1)) / squares
    }

    /// Returns the rows that components stand for.
    ///
    /// # Shapes
    /// `[N, k]` to `[N, size]`.
    pub(crate) fn rows(&self, codes: Tensor<2>) -> Tensor<2> {
        let (directions, mean) = self.tensors(&codes.device());
        codes.matmul(directions) + mean
    }

    /// Returns the components of rows of numbers, in standard deviations.
    ///
    /// # Shapes
    /// `[N, size]` to `[N, k]`, row-major.
    ///
    /// # Errors
    /// Tensor data that cannot be read from the device.
    pub fn encode(&self, rows: Vec<f32>) -> Result<Vec<f32>, RepresentationError> {
        let shape = [rows.len() / self.mean.len(), self.mean.len()];
        Ok(read(self.codes(Tensor::from_data(TensorData::new(rows, shape), &device::inference())))?)
    }

    /// Returns the rows that components stand for.
    ///
    /// # Shapes
    /// `[N, k]` to `[N, size]`, row-major.
    ///
    /// # Errors
    /// Tensor data that cannot be read from the device.
    pub fn decode(&self, codes: &[f32]) -> Result<Vec<f32>, RepresentationError> {
        let z = TensorData::new(codes.to_vec(), [codes.len() / self.latent, self.latent]);
        Ok(read(self.rows(Tensor::from_data(z, &device::inference())))?)
    }

    /// Directions `[k, size]` and the mean `[1, size]`.
    fn tensors(&self, device: &Device) -> (Tensor<2>, Tensor<2>) {
        let size = self.mean.len();
        let rows = TensorData::new(self.directions.clone(), [self.latent, size]);
        let mean = TensorData::new(self.mean.clone(), [1, size]);
        (Tensor::from_data(rows, device), Tensor::from_data(mean, device))
    }
}
