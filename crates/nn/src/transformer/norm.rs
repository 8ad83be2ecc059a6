//! T5's layer normalization.

use burn::module::{Module, Param};
use burn::tensor::{Device, Tensor};

use crate::init;

/// T5's.
pub(crate) const EPSILON: f64 = 1e-6;

/// Divides each token by the root of its mean square and multiplies by a gain: no mean is subtracted and nothing added
/// (Zhang & Sennrich 2019, as in T5, Raffel et al. 2020).
#[derive(Module, Debug)]
pub struct RmsNorm {
    pub(crate) gain: Param<Tensor<1>>,
}

impl RmsNorm {
    /// Gain 1 for `width`.
    pub fn new(width: usize, device: &Device) -> Self {
        Self { gain: init::parameter(vec![1.0; width], [width], device) }
    }

    /// # Shapes
    /// `[B, T, c]` to the same.
    pub fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        let root = x.clone().square().mean_dim(2).add_scalar(EPSILON).sqrt();
        x / root * self.gain.val().unsqueeze::<3>()
    }
}
