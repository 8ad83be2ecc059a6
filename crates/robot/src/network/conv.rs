//! The encoder of the convolutional motion prior (thesis 4.2.1 and 4.3.1), its mean only.
//!
//! ```text
//! [T, F] -> pad to a multiple of 4 -> Down, ReLU, Down -> residual blocks -> LayerNorm, ReLU -> linear -> μ  [d_z]
//! ```
//!
//! `Down` halves the time steps (kernel 4, stride 2, padding 1); a block is
//! `x + conv1(relu(norm(conv3(relu(norm(x))))))`. Convolutions are matrix products over the taps, without biases.

use lifelike_checkpoint::{Checkpoint, CheckpointError};
use lifelike_dense::layer_norm;

use super::{Weights, Workspace};

/// PyTorch's default.
const EPSILON: f32 = 1e-5;
/// Time steps are halved this often.
const HALVINGS: usize = 2;

#[derive(Debug, Clone, PartialEq)]
struct Block {
    norm_1: Vec<f32>,
    /// Taps that look one step back, at the step itself, one step ahead; `[C, C]` each.
    conv_1: [Vec<f32>; 3],
    norm_2: Vec<f32>,
    conv_2: Vec<f32>,
}

/// Weights of the encoder.
#[derive(Debug, Clone, PartialEq)]
pub struct ConvEncoder {
    samples: usize,
    features: usize,
    channels: usize,
    latent: usize,
    /// `[4 F, C]`, tap by tap, earliest first.
    down_1: Vec<f32>,
    /// `[4 C, C]`.
    down_2: Vec<f32>,
    blocks: Vec<Block>,
    norm: Vec<f32>,
    /// `[steps · C, 2 d_z]`, mean and log variance; the mean's columns are used.
    out: Vec<f32>,
    out_bias: Vec<f32>,
}

/// Sizes of a [`ConvEncoder`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ConvSizes {
    /// Samples of a window.
    pub(crate) samples: usize,
    /// Numbers of a sample.
    pub(crate) features: usize,
    /// Width of the convolutions.
    pub(crate) channels: usize,
    /// Residual blocks.
    pub(crate) blocks: usize,
    /// d_z.
    pub(crate) latent: usize,
}

impl ConvEncoder {
    /// Reads the encoder under `prefix`.
    ///
    /// # Errors
    /// An array is missing or of another shape.
    pub(crate) fn load(file: &Checkpoint, prefix: &str, sizes: ConvSizes) -> Result<Self, CheckpointError> {
        let ConvSizes { samples, features, channels: c, blocks, latent } = sizes;
        let from = Weights::under(file, prefix);
        let block = |i: usize| {
            let get = |name: &str, shape: &[usize]| from.f32s(&format!("encoder_blocks.{i}.{name}"), shape);
            let tap = |k: usize| get(&format!("conv_1.weight_{k}"), &[c, c]);
            Ok(Block {
                norm_1: get("norm_1.gain", &[c])?,
                conv_1: [tap(0)?, tap(1)?, tap(2)?],
                norm_2: get("norm_2.gain", &[c])?,
                conv_2: get("conv_2.weight", &[c, c])?,
            })
        };
        let steps = samples.div_ceil(1 << HALVINGS);
        Ok(Self {
            samples,
            features,
            channels: c,
            latent,
            down_1: from.f32s("encoder_in.weight", &[features.saturating_mul(4), c])?,
            down_2: from.f32s("encoder_down.weight", &[c.saturating_mul(4), c])?,
            blocks: (0..blocks).map(block).collect::<Result<_, CheckpointError>>()?,
            norm: from.f32s("encoder_norm.gain", &[c])?,
            out: from.f32s("encoder_out.weight", &[steps.saturating_mul(c), latent.saturating_mul(2)])?,
            out_bias: from.f32s("encoder_out.bias", &[latent.saturating_mul(2)])?,
        })
    }

    /// Writes the encoder as [`Self::load`] reads it.
    ///
    /// # Errors
    /// The names are taken.
    pub(crate) fn save_into(&self, file: &mut Checkpoint, prefix: &str) -> Result<(), CheckpointError> {
        let (c, f) = (self.channels, self.features);
        let mut put = |name: &str, shape: &[usize], values: &Vec<f32>| {
            file.put_f32(&format!("{prefix}.{name}"), shape, values.clone())
        };
        put("encoder_in.weight", &[4 * f, c], &self.down_1)?;
        put("encoder_down.weight", &[4 * c, c], &self.down_2)?;
        for (i, block) in self.blocks.iter().enumerate() {
            let name = |part: &str| format!("encoder_blocks.{i}.{part}");
            put(&name("norm_1.gain"), &[c], &block.norm_1)?;
            for (k, tap) in block.conv_1.iter().enumerate() {
                put(&name(&format!("conv_1.weight_{k}")), &[c, c], tap)?;
            }
            put(&name("norm_2.gain"), &[c], &block.norm_2)?;
            put(&name("conv_2.weight"), &[c, c], &block.conv_2)?;
        }
        put("encoder_norm.gain", &[c], &self.norm)?;
        put("encoder_out.weight", &[self.steps() * c, 2 * self.latent], &self.out)?;
        put("encoder_out.bias", &[2 * self.latent], &self.out_bias)
    }

    /// Numbers of a window.
    pub fn inputs(&self) -> usize {
        self.samples * self.features
    }

    fn steps(&self) -> usize {
        self.samples.div_ceil(1 << HALVINGS)
    }

    /// Writes the mean of the latent of normalised windows.
    ///
    /// # Shapes
    /// `windows: [B, T, F]` to `codes: [B, d_z]`.
    ///
    /// # Panics
    /// `windows` or `codes` has another length.
    pub fn encode(&self, windows: &[f32], work: &mut Workspace, codes: &mut [f32]) {
        let b = windows.len() / self.inputs().max(1);
        assert_eq!((windows.len(), codes.len()), (b * self.inputs(), b * self.latent), "windows of an encoder");
        let (c, f, steps) = (self.channels, self.features, self.steps());
        let padded = steps << HALVINGS;
        let before = (padded - self.samples) / 2;
        let widest = [2 * steps * 4 * f, (padded + 2) * f, 4 * steps * c, (2 * steps + 2) * c, 2 * self.latent];
        let ([x, y, z, taps], live) = work.parts(b * widest.into_iter().max().unwrap_or(0));

        for (window, row) in windows.chunks_exact(self.inputs()).zip(x.chunks_exact_mut(padded * f)) {
            row.fill(0.0);
            row[before * f..][..window.len()].copy_from_slice(window);
        }
        halve(x, &self.down_1, [b, padded, f, c], live, taps, y);
        y[..b * 2 * steps * c].iter_mut().for_each(|y| *y = y.max(0.0));
        halve(y, &self.down_2, [b, 2 * steps, c, c], live, taps, x);
        let size = b * steps * c;
        for block in &self.blocks {
            y[..size].copy_from_slice(&x[..size]);
            rectified_norm(&mut y[..size], &block.norm_1);
            self.convolve(&y[..size], &block.conv_1, live, &mut z[..size], &mut taps[..size]);
            rectified_norm(&mut z[..size], &block.norm_2);
            Workspace::product(live, &z[..size], &block.conv_2, [b * steps, c, c], &mut y[..size]);
            x[..size].iter_mut().zip(&y[..size]).for_each(|(x, y)| *x += y);
        }
        rectified_norm(&mut x[..size], &self.norm);
        let both = &mut y[..b * 2 * self.latent];
        Workspace::product(live, &x[..size], &self.out, [b, steps * c, 2 * self.latent], both);
        for (code, both) in codes.chunks_exact_mut(self.latent).zip(both.chunks_exact(2 * self.latent)) {
            code.iter_mut().zip(both).zip(&self.out_bias).for_each(|((z, y), bias)| *z = y + bias);
        }
    }

    /// The convolution with kernel 3 and padding 1 of `x: [B, steps, C]`.
    fn convolve(&self, x: &[f32], taps: &[Vec<f32>; 3], live: bool, out: &mut [f32], other: &mut [f32]) {
        let (c, window) = (self.channels, self.steps() * self.channels);
        let sizes = [x.len() / c.max(1), c, c];
        Workspace::product(live, x, &taps[1], sizes, out);
        Workspace::product(live, x, &taps[0], sizes, other);
        for (out, late) in out.chunks_exact_mut(window).zip(other.chunks_exact(window)) {
            out[c..].iter_mut().zip(late).for_each(|(y, late)| *y += late);
        }
        Workspace::product(live, x, &taps[2], sizes, other);
        for (out, early) in out.chunks_exact_mut(window).zip(other.chunks_exact(window)) {
            out.iter_mut().zip(&early[c..]).for_each(|(y, early)| *y += early);
        }
    }
}

/// Half as many time steps: kernel 4, stride 2, padding 1, `x: [B, T, K]` to `out: [B, T/2, C]`.
fn halve(x: &[f32], weight: &[f32], [b, t, k, c]: [usize; 4], live: bool, taps: &mut [f32], out: &mut [f32]) {
    let half = t / 2;
    for (window, taps) in x.chunks_exact(t * k).zip(taps.chunks_exact_mut(half * 4 * k)).take(b) {
        for (step, taps) in taps.chunks_exact_mut(4 * k).enumerate() {
            // Steps 2s − 1 to 2s + 2; those outside are zero.
            let first = 2 * step * k;
            taps[..k].fill(0.0);
            if step > 0 {
                taps[..k].copy_from_slice(&window[first - k..first]);
            }
            let there = (window.len() - first).min(3 * k);
            taps[k..k + there].copy_from_slice(&window[first..first + there]);
            taps[k + there..].fill(0.0);
        }
    }
    Workspace::product(live, &taps[..b * half * 4 * k], weight, [b * half, 4 * k, c], &mut out[..b * half * c]);
}

fn rectified_norm(rows: &mut [f32], gain: &[f32]) {
    layer_norm(rows, gain, EPSILON);
    rows.iter_mut().for_each(|x| *x = x.max(0.0));
}
