//! Pre-norm transformer blocks, one after the other.

use burn::module::Module;
use burn::tensor::{Device, Tensor};

use super::attention::Attention;
use super::feed_forward::FeedForward;
use super::norm::RmsNorm;

/// x + attention(norm(x)), then x + feed-forward(norm(x)): T5's order, in which nothing stands on the way from input to
/// output but additions.
#[derive(Module, Debug)]
pub struct Block {
    pub(crate) norm_1: RmsNorm,
    pub(crate) attention: Attention,
    pub(crate) norm_2: RmsNorm,
    pub(crate) feed_forward: FeedForward,
}

impl Block {
    /// `factor` is the feed-forward part's inner width by `width`; the streams are addressed by `purpose`.
    pub fn new(width: usize, heads: usize, factor: usize, seed: u64, purpose: &str, device: &Device) -> Self {
        Self {
            norm_1: RmsNorm::new(width, device),
            attention: Attention::new(width, heads, seed, &format!("{purpose}.attention"), device),
            norm_2: RmsNorm::new(width, device),
            feed_forward: FeedForward::new(width, factor, seed, &format!("{purpose}.feed_forward"), device),
        }
    }

    /// # Shapes
    /// `x: [B, T, c]`, `bias: [h, T, T]` to `[B, T, c]`.
    pub fn forward(&self, x: Tensor<3>, bias: Tensor<3>) -> Tensor<3> {
        let x = x.clone() + self.attention.forward(self.norm_1.forward(x), bias);
        x.clone() + self.feed_forward.forward(self.norm_2.forward(x))
    }
}

/// Blocks and, because a pre-norm block leaves its sum as it is, one more normalization at the end (T5's
/// `final_layer_norm`).
#[derive(Module, Debug)]
pub struct Stack {
    pub(crate) blocks: Vec<Block>,
    pub(crate) norm: RmsNorm,
}

impl Stack {
    /// `layers` blocks; see [`Block::new`].
    pub fn new(layers: usize, [width, heads, factor]: [usize; 3], seed: u64, purpose: &str, device: &Device) -> Self {
        let block = |i| Block::new(width, heads, factor, seed, &format!("{purpose}.{i}"), device);
        Self { blocks: (0..layers).map(block).collect(), norm: RmsNorm::new(width, device) }
    }

    /// # Shapes
    /// `x: [B, T, c]`, `bias: [h, T, T]` to `[B, T, c]`.
    pub fn forward(&self, mut x: Tensor<3>, bias: Tensor<3>) -> Tensor<3> {
        for block in &self.blocks {
            x = block.forward(x, bias.clone());
        }
        self.norm.forward(x)
    }
}
