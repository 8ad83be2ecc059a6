//! The per-token half of a transformer block.

use burn::module::{Module, Param};
use burn::tensor::activation::gelu;
use burn::tensor::{Device, Tensor};

use super::heads::weight;

/// Two linear maps without bias (as T5's) with GELU between them, the exact one by the error function (Hendrycks & Gimpel
/// 2016). The thesis' inner width is the outer one (factor 1).
#[derive(Module, Debug)]
pub struct FeedForward {
    pub(crate) inner: Param<Tensor<2>>,
    pub(crate) outer: Param<Tensor<2>>,
}

impl FeedForward {
    /// Returns normal weights of standard deviation 1/√(numbers in) from the streams `(seed, purpose.NAME, 0, 0)`.
    pub fn new(width: usize, factor: usize, seed: u64, purpose: &str, device: &Device) -> Self {
        Self {
            inner: weight(width, factor * width, seed, &format!("{purpose}.inner"), device),
            outer: weight(factor * width, width, seed, &format!("{purpose}.outer"), device),
        }
    }

    /// # Shapes
    /// `[B, T, c]` to the same.
    pub fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        let [b, t, c] = x.dims();
        gelu(x.reshape([b * t, c]).matmul(self.inner.val())).matmul(self.outer.val()).reshape([b, t, c])
    }
}
