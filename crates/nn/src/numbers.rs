//! Tensor data as plain numbers.

use burn::tensor::Tensor;

/// Tensor data that could not be read from its device.
#[derive(Debug, thiserror::Error)]
#[error("tensor data could not be read from the device: {0}")]
pub struct Unreadable(String);

/// Reads a tensor's data, row-major.
///
/// # Errors
/// Tensor data that cannot be read from the device.
pub fn read<const D: usize>(tensor: Tensor<D>) -> Result<Vec<f32>, Unreadable> {
    tensor.try_into_vec_as::<f32>().map_err(|e| Unreadable(e.to_string()))
}
