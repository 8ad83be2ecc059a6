//! A tensor's numbers.

use burn::tensor::Tensor;

/// The tensor library did not hand out its numbers.
#[derive(Debug, thiserror::Error)]
#[error("cannot read a tensor: {0}")]
pub struct Unreadable(String);

/// All of them, row-major.
///
/// # Errors
/// The device does not hand them out.
pub fn read<const D: usize>(tensor: Tensor<D>) -> Result<Vec<f32>, Unreadable> {
    tensor.try_into_vec_as::<f32>().map_err(|e| Unreadable(e.to_string()))
}
