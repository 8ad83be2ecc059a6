//! The two encoders.
//!
//! ```text
//! rows  [B, T, F] -> Down, ReLU, Down, ReLU -> residual blocks -> mean and maximum -> linear   [B, width]
//! words [B, L]    -> learned table          -> residual blocks -> mean and maximum -> linear   [B, width]
//! ```

use burn::module::{Module, Param};
use burn::tensor::activation::relu;
use burn::tensor::{Device, Tensor};
use lifelike_checkpoint::rng::stream;
use lifelike_nn::conv_resnet::Down;
use lifelike_nn::init;

use super::batch;
use super::encoder::PooledEncoder;
use super::plan::EvaluatorPlan;

/// Rows that become one step.
const STEP: usize = 4;

/// Encoders of motions and of sentences.
#[derive(Module, Debug)]
pub struct EvaluatorNetwork {
    motion_in: Down,
    motion_down: Down,
    motion: PooledEncoder,
    table: Param<Tensor<2>>,
    text: PooledEncoder,
    #[module(skip)]
    features: usize,
}

impl EvaluatorNetwork {
    /// Returns networks for rows of `features` numbers and a vocabulary of `pieces`, with weights from the plan's seed.
    pub fn new(plan: &EvaluatorPlan, features: usize, pieces: usize, device: &Device) -> Self {
        let (c, seed) = (plan.channels, plan.seed);
        let table = init::normal(&mut stream(seed, "evaluator.table", 0, 0), pieces * c, 1.0);
        Self {
            motion_in: Down::new(features, c, seed, "evaluator.motion_in", device),
            motion_down: Down::new(c, c, seed, "evaluator.motion_down", device),
            motion: PooledEncoder::new(c, plan.motion_blocks, plan.width, seed, "evaluator.motion", device),
            table: init::parameter(table, [pieces, c], device),
            text: PooledEncoder::new(c, plan.text_blocks, plan.width, seed, "evaluator.text", device),
            features,
        }
    }

    /// Returns the embeddings of standardized motions, each `[n_i, F]`, as `[B, width]`.
    pub fn motions(&self, motions: &[Vec<f32>], device: &Device) -> Tensor<2> {
        let padded = batch::rows(motions, self.features, STEP, device);
        let steps = padded.values.dims()[1];
        let mask = |halvings: usize| {
            let lengths: Vec<usize> = padded.lengths.iter().map(|n| n.div_ceil(1 << halvings)).collect();
            batch::mask(&lengths, steps >> halvings, device)
        };
        let x = relu(self.motion_in.forward(padded.values)) * mask(1).swap_dims(0, 1);
        let x = relu(self.motion_down.forward(x)).swap_dims(0, 1);
        self.motion.forward(x, mask(2))
    }

    /// Returns the embeddings of sentences as `[B, width]`.
    pub fn sentences(&self, sentences: &[Vec<u32>], device: &Device) -> Tensor<2> {
        let padded = batch::ids(sentences, device);
        let (b, c) = (sentences.len(), self.table.dims()[1]);
        let longest = padded.values.dims()[0] / b.max(1);
        let x = self.table.val().select(0, padded.values).reshape([b, longest, c]);
        self.text.forward(x.swap_dims(0, 1), batch::mask(&padded.lengths, longest, device))
    }
}
