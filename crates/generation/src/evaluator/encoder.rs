//! A sequence of any length to one embedding.

use lifelike_checkpoint::rng;
use lifelike_nn::conv_resnet::{ChannelNorm, ResBlock, ResBlockPass, add_block, add_norm};
use lifelike_nn::init;
use lifelike_nn::parameters::{ParameterList, Parameters};
use lifelike_nn::rows::Linear;

/// Gain of the last layer: distances begin small enough that the loss sees all pairs.
const GAIN: f64 = 0.3;

/// Adds the parameters of a [`PooledEncoder`] under `PREFIX.`, with weights from the streams of `purpose`.
pub(super) fn add_encoder(
    list: &mut ParameterList,
    prefix: &str,
    [channels, blocks, width]: [usize; 3],
    seed: u64,
    purpose: &str,
) {
    for i in 0..blocks {
        add_block(list, &format!("{prefix}.blocks.{i}"), channels, seed, &format!("{purpose}.block{i}"));
    }
    add_norm(list, &format!("{prefix}.norm"), channels);
    let mut rng = rng::stream(seed, &format!("{purpose}.out"), 0, 0);
    let weight = init::uniform_by_fan_in(&mut rng, 2 * channels * width, 2 * channels, GAIN);
    list.add(format!("{prefix}.out.weight"), &[2 * channels, width], weight);
    list.add(format!("{prefix}.out.bias"), &[width], vec![0.0; width]);
}

/// Residual blocks over time, then mean and maximum over time, then one linear layer.
#[derive(Debug)]
pub(super) struct PooledEncoder {
    channels: usize,
    blocks: Vec<ResBlock>,
    norm: ChannelNorm,
    out: Linear,
}

/// Numbers that the backward pass needs.
#[derive(Debug)]
pub(super) struct PooledPass {
    lengths: Vec<usize>,
    blocks: Vec<ResBlockPass>,
    last: Vec<f32>,
    pooled: Vec<f32>,
    /// Step at which each channel of each sequence is largest, `[B, C]`.
    largest: Vec<usize>,
}

impl PooledEncoder {
    pub(super) fn new(prefix: &str, [channels, blocks, width]: [usize; 3], parameters: &Parameters) -> Self {
        let out = [2 * channels, width];
        Self {
            channels,
            blocks: (0..blocks).map(|i| ResBlock::new(&format!("{prefix}.blocks.{i}"), channels, parameters)).collect(),
            norm: ChannelNorm::new(&format!("{prefix}.norm"), parameters),
            out: Linear::new(&format!("{prefix}.out"), out, parameters.layout(), parameters.values()),
        }
    }

    /// Returns the embeddings. Padding is set to zero after every block, so that a sequence's embedding does not depend
    /// on how much follows it.
    ///
    /// # Shapes
    /// `x: [T, B, C]`, zeros where padding is; B `lengths` to `[B, width]`.
    pub(super) fn forward(&self, mut x: Vec<f32>, lengths: &[usize]) -> (Vec<f32>, PooledPass) {
        let steps = x.len() / (lengths.len() * self.channels);
        let mut blocks = Vec::with_capacity(self.blocks.len());
        for block in &self.blocks {
            let (mut next, pass) = block.forward(x, steps);
            clear_padding(&mut next, lengths, self.channels);
            blocks.push(pass);
            x = next;
        }
        let (pooled, largest) = self.pool(&self.norm.forward(&x), lengths);
        (self.out.forward(&pooled), PooledPass { lengths: lengths.to_vec(), blocks, last: x, pooled, largest })
    }

    /// Mean and maximum over the steps of each sequence, `[B, 2 C]`.
    fn pool(&self, x: &[f32], lengths: &[usize]) -> (Vec<f32>, Vec<usize>) {
        let (batch, c) = (lengths.len(), self.channels);
        let (mut pooled, mut largest) = (vec![0.0; batch * 2 * c], vec![0; batch * c]);
        for (b, length) in lengths.iter().enumerate() {
            let (mean, most) = pooled[b * 2 * c..][..2 * c].split_at_mut(c);
            most.fill(if *length == 0 { 0.0 } else { f32::NEG_INFINITY });
            for step in 0..*length {
                let row = &x[(step * batch + b) * c..][..c];
                for (i, x) in row.iter().enumerate() {
                    mean[i] += x / *length as f32;
                    if *x > most[i] {
                        (most[i], largest[b * c + i]) = (*x, step);
                    }
                }
            }
        }
        (pooled, largest)
    }

    /// Adds the parameters' gradients; returns that by x.
    pub(super) fn backward(&self, pass: PooledPass, gradient: &[f32], sums: &mut [f32]) -> Vec<f32> {
        let PooledPass { lengths, blocks, last, pooled, largest } = pass;
        let (batch, c) = (lengths.len(), self.channels);
        let steps = last.len() / (batch * c);
        let by_pooled = self.out.backward(&pooled, gradient, sums);
        let mut by_normed = vec![0.0; last.len()];
        for (b, length) in lengths.iter().enumerate() {
            let (by_mean, by_most) = by_pooled[b * 2 * c..][..2 * c].split_at(c);
            for step in 0..*length {
                let row = &mut by_normed[(step * batch + b) * c..][..c];
                row.iter_mut().zip(by_mean).for_each(|(x, by)| *x += by / *length as f32);
            }
            for (i, by) in by_most.iter().enumerate() {
                by_normed[(largest[b * c + i] * batch + b) * c + i] += by;
            }
        }
        let mut by_x = self.norm.backward(&last, &by_normed, sums);
        for (block, pass) in self.blocks.iter().zip(&blocks).rev() {
            clear_padding(&mut by_x, &lengths, c);
            by_x = block.backward(pass, by_x, steps, sums);
        }
        by_x
    }
}

/// Sets to zero what stands beyond the end of each sequence.
///
/// # Shapes
/// `x: [T, B, C]`.
pub(super) fn clear_padding(x: &mut [f32], lengths: &[usize], channels: usize) {
    for (step, rows) in x.chunks_exact_mut(lengths.len() * channels).enumerate() {
        for (row, length) in rows.chunks_exact_mut(channels).zip(lengths) {
            if step >= *length {
                row.fill(0.0);
            }
        }
    }
}
