//! A sequence of any length to one embedding.

use burn::module::Module;
use burn::nn::Linear;
use burn::tensor::{Device, Tensor};
use lifelike_checkpoint::rng;
use lifelike_nn::conv_resnet::{ChannelNorm, ResBlock};
use lifelike_nn::init;

/// Added to what is padding before a maximum is taken.
const FAR_BELOW: f64 = -1e6;
/// Gain of the last layer: distances begin small enough that the loss sees all pairs.
const GAIN: f64 = 0.3;

/// Residual blocks over time, then mean and maximum over time, then one linear layer.
#[derive(Module, Debug)]
pub struct PooledEncoder {
    blocks: Vec<ResBlock>,
    norm: ChannelNorm,
    out: Linear,
}

impl PooledEncoder {
    /// Returns an encoder with weights from the streams of `purpose`.
    pub fn new(channels: usize, blocks: usize, width: usize, seed: u64, purpose: &str, device: &Device) -> Self {
        let block = |i: usize| ResBlock::new(channels, seed, &format!("{purpose}.block{i}"), device);
        let mut rng = rng::stream(seed, &format!("{purpose}.out"), 0, 0);
        let weight = init::uniform_by_fan_in(&mut rng, 2 * channels * width, 2 * channels, GAIN);
        Self {
            blocks: (0..blocks).map(block).collect(),
            norm: ChannelNorm::new(channels, device),
            out: Linear {
                weight: init::parameter(weight, [2 * channels, width], device),
                bias: Some(init::parameter(vec![0.0; width], [width], device)),
            },
        }
    }

    /// Returns the embeddings. Padding is set to zero after every block, so that a sequence's embedding does not depend
    /// on how much follows it.
    ///
    /// # Shapes
    /// `x: [T, B, C]`, `mask: [T, B, 1]` to `[B, width]`.
    pub fn forward(&self, x: Tensor<3>, mask: Tensor<3>) -> Tensor<2> {
        let [_, b, c] = x.dims();
        let x = self.blocks.iter().fold(x * mask.clone(), |x, block| block.forward(x) * mask.clone());
        let x = self.norm.forward(x) * mask.clone();
        let mean = x.clone().sum_dim(0) / mask.clone().sum_dim(0).clamp_min(1.0);
        let padding = (mask.neg() + 1.0).mul_scalar(FAR_BELOW);
        let most = (x + padding).max_dim(0);
        self.out.forward(Tensor::cat(vec![mean, most], 2).reshape([b, 2 * c]))
    }
}
