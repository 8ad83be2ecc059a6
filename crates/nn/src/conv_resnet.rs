//! One-dimensional convolutions over time, channels last, and the residual block of the thesis' motion prior (4.3.1), forward and
//! backward.
//!
//! Rows are time-major, `[T, B, C]`: a shift by one step is a contiguous slice, so each tap of a convolution is one matrix product of
//! everything. A pass is one thread's work; who has several cores gives each its part of a batch.
//!
//! Parameters are added to a network's by [`add_conv3`], [`add_down`], [`add_up`], [`add_norm`] and [`add_block`].

use std::ops::Range;

use lifelike_checkpoint::rng;

use crate::init;
use crate::parameters::{ParameterList, Parameters};
use crate::rows::{Linear, add, layer_norm};

/// Adds the taps `PREFIX.weight_K`, `[inputs, outputs]`, of a convolution with kernel 3: uniform by He et al. from the streams
/// `(seed, purpose.K, 0, 0)`.
pub fn add_conv3(list: &mut ParameterList, prefix: &str, [inputs, outputs]: [usize; 2], seed: u64, purpose: &str) {
    for tap in 0..3 {
        let values = uniform(inputs * outputs, 3 * inputs, seed, &format!("{purpose}.{tap}"));
        list.add(format!("{prefix}.weight_{tap}"), &[inputs, outputs], values);
    }
}

/// Adds the weight `PREFIX.weight`, `[4 inputs, outputs]`, of [`Down`].
pub fn add_down(list: &mut ParameterList, prefix: &str, [inputs, outputs]: [usize; 2], seed: u64, purpose: &str) {
    let values = uniform(4 * inputs * outputs, 4 * inputs, seed, purpose);
    list.add(format!("{prefix}.weight"), &[4 * inputs, outputs], values);
}

/// Adds the weight `PREFIX.weight`, `[inputs, 4 outputs]`, of [`Up`].
pub fn add_up(list: &mut ParameterList, prefix: &str, [inputs, outputs]: [usize; 2], seed: u64, purpose: &str) {
    // Every output step receives two of the four taps.
    let values = uniform(inputs * 4 * outputs, 2 * inputs, seed, purpose);
    list.add(format!("{prefix}.weight"), &[inputs, 4 * outputs], values);
}

/// Adds the gain `PREFIX.gain` of [`ChannelNorm`], 1 at first.
pub fn add_norm(list: &mut ParameterList, prefix: &str, channels: usize) {
    list.add(format!("{prefix}.gain"), &[channels], vec![1.0; channels]);
}

/// Adds the parameters of [`ResBlock`].
pub fn add_block(list: &mut ParameterList, prefix: &str, channels: usize, seed: u64, purpose: &str) {
    add_norm(list, &format!("{prefix}.norm_1"), channels);
    add_conv3(list, &format!("{prefix}.conv_1"), [channels; 2], seed, &format!("{purpose}.conv_1"));
    add_norm(list, &format!("{prefix}.norm_2"), channels);
    let values = uniform(channels * channels, channels, seed, &format!("{purpose}.conv_2"));
    list.add(format!("{prefix}.conv_2.weight"), &[channels, channels], values);
}

fn uniform(count: usize, fan_in: usize, seed: u64, purpose: &str) -> Vec<f32> {
    init::uniform_by_fan_in(&mut rng::stream(seed, purpose, 0, 0), count, fan_in, 1.0)
}

/// Layer normalization over channels (Ba et al. 2016) with a gain and no bias.
#[derive(Debug, Clone)]
pub struct ChannelNorm {
    gain: Vec<f32>,
    place: Range<usize>,
}

impl ChannelNorm {
    /// Takes the gain `NAME.gain`.
    pub fn new(name: &str, parameters: &Parameters) -> Self {
        let place = parameters.range(&format!("{name}.gain"));
        Self { gain: parameters.values()[place.clone()].to_vec(), place }
    }

    /// # Shapes
    /// `[.., C]` to the same.
    pub fn forward(&self, x: &[f32]) -> Vec<f32> {
        layer_norm::forward(x, &self.gain, &vec![0.0; self.gain.len()])
    }

    /// Returns the gradient by x, from the one by the output; adds the gain's.
    pub fn backward(&self, x: &[f32], gradient: &[f32], sums: &mut [f32]) -> Vec<f32> {
        let mut no_bias = vec![0.0; self.gain.len()];
        layer_norm::backward(x, &self.gain, gradient, (&mut sums[self.place.clone()], &mut no_bias))
    }
}

/// A convolution with kernel 3, stride 1, zero padding 1, no bias.
///
/// Tap 0 looks one step back, tap 1 at the step itself, tap 2 one step ahead.
#[derive(Debug, Clone)]
pub struct Conv3([Linear; 3]);

impl Conv3 {
    /// Takes the taps `NAME.weight_K`.
    pub fn new(name: &str, shape: [usize; 2], parameters: &Parameters) -> Self {
        Self([0, 1, 2].map(|tap| map(&format!("{name}.weight_{tap}"), shape, parameters)))
    }

    /// # Shapes
    /// `[T, B, Cin]` to `[T, B, Cout]`, of `steps` T.
    pub fn forward(&self, x: &[f32], steps: usize) -> Vec<f32> {
        let Self([back, here, ahead]) = self;
        let (step, mut out) = (x.len() / steps, here.forward(x));
        let shift = out.len() / steps;
        add(&mut out[shift..], &back.forward(&x[..x.len() - step]));
        let rest = out.len() - shift;
        add(&mut out[..rest], &ahead.forward(&x[step..]));
        out
    }

    /// Returns the gradient by x, from the one by the output; adds those of the taps.
    pub fn backward(&self, x: &[f32], gradient: &[f32], steps: usize, sums: &mut [f32]) -> Vec<f32> {
        let Self([back, here, ahead]) = self;
        let (step, shift) = (x.len() / steps, gradient.len() / steps);
        let mut out = here.backward(x, gradient, sums);
        let earlier = x.len() - step;
        add(&mut out[..earlier], &back.backward(&x[..earlier], &gradient[shift..], sums));
        add(&mut out[step..], &ahead.backward(&x[step..], &gradient[..gradient.len() - shift], sums));
        out
    }
}

/// Halves the number of time steps: kernel 4, stride 2, zero padding 1, no bias. T must be even.
///
/// The weight is `[4 Cin, Cout]`: tap by tap, earliest first.
#[derive(Debug, Clone)]
pub struct Down {
    map: Linear,
    inputs: usize,
}

impl Down {
    /// Takes the weight `NAME.weight`.
    pub fn new(name: &str, [inputs, outputs]: [usize; 2], parameters: &Parameters) -> Self {
        Self { map: map(&format!("{name}.weight"), [4 * inputs, outputs], parameters), inputs }
    }

    /// # Shapes
    /// `[T, B, Cin]` to `[T/2, B, Cout]`, of `steps` T.
    pub fn forward(&self, x: &[f32], steps: usize) -> Vec<f32> {
        self.map.forward(&taps(x, steps, self.inputs))
    }

    /// Returns the gradient by x, from the one by the output; adds the weight's.
    pub fn backward(&self, x: &[f32], gradient: &[f32], steps: usize, sums: &mut [f32]) -> Vec<f32> {
        let by_taps = self.map.backward(&taps(x, steps, self.inputs), gradient, sums);
        untaps(&by_taps, steps, self.inputs)
    }
}

/// Doubles the number of time steps: the transpose of [`Down`], no bias.
///
/// The weight is `[Cin, 4 Cout]`: tap by tap, earliest first.
#[derive(Debug, Clone)]
pub struct Up {
    map: Linear,
    outputs: usize,
}

impl Up {
    /// Takes the weight `NAME.weight`.
    pub fn new(name: &str, [inputs, outputs]: [usize; 2], parameters: &Parameters) -> Self {
        Self { map: map(&format!("{name}.weight"), [inputs, 4 * outputs], parameters), outputs }
    }

    /// # Shapes
    /// `[T, B, Cin]` to `[2T, B, Cout]`, of `steps` T.
    pub fn forward(&self, x: &[f32], steps: usize) -> Vec<f32> {
        untaps(&self.map.forward(x), 2 * steps, self.outputs)
    }

    /// Returns the gradient by x, from the one by the output; adds the weight's.
    pub fn backward(&self, x: &[f32], gradient: &[f32], steps: usize, sums: &mut [f32]) -> Vec<f32> {
        self.map.backward(x, &taps(gradient, 2 * steps, self.outputs), sums)
    }
}

/// Returns the four steps that each pair of steps sees: itself, one before and one after, zeros beyond the ends.
///
/// # Shapes
/// `[T, B, C]` to `[T/2, B, 4 C]`, of `steps` T.
fn taps(x: &[f32], steps: usize, channels: usize) -> Vec<f32> {
    let step = x.len() / steps;
    let mut out = vec![0.0; 2 * x.len()];
    for (pair, out) in out.chunks_exact_mut(4 * step).enumerate() {
        for tap in 0..4 {
            let Some(from) = (2 * pair + tap).checked_sub(1).filter(|from| *from < steps) else { continue };
            let rows = x[from * step..][..step].chunks_exact(channels);
            for (out, row) in out.chunks_exact_mut(4 * channels).zip(rows) {
                out[tap * channels..][..channels].copy_from_slice(row);
            }
        }
    }
    out
}

/// Returns the sum of what [`taps`] copied: its transpose.
///
/// # Shapes
/// `[T/2, B, 4 C]` to `[T, B, C]`, of `steps` T.
fn untaps(taps: &[f32], steps: usize, channels: usize) -> Vec<f32> {
    let mut out = vec![0.0; taps.len() / 2];
    let step = out.len() / steps;
    for (pair, taps) in taps.chunks_exact(4 * step).enumerate() {
        for tap in 0..4 {
            let Some(to) = (2 * pair + tap).checked_sub(1).filter(|to| *to < steps) else { continue };
            let rows = out[to * step..][..step].chunks_exact_mut(channels);
            for (out, row) in rows.zip(taps.chunks_exact(4 * channels)) {
                add(out, &row[tap * channels..][..channels]);
            }
        }
    }
    out
}

/// The residual block: x + conv1(relu(norm(conv3(relu(norm(x)))))), after Dhariwal et al. 2020's `ResConv1DBlock` (ReLU,
/// kernel 3, ReLU, kernel 1) with the thesis' layer normalization before each ReLU and without biases.
#[derive(Debug, Clone)]
pub struct ResBlock {
    norm_1: ChannelNorm,
    conv_1: Conv3,
    norm_2: ChannelNorm,
    conv_2: Linear,
}

/// Numbers that the backward pass of a block needs.
#[derive(Debug, Clone)]
pub struct ResBlockPass {
    x: Vec<f32>,
    first: Vec<f32>,
    between: Vec<f32>,
    second: Vec<f32>,
}

impl ResBlock {
    /// Takes the parameters under `NAME.`.
    pub fn new(name: &str, channels: usize, parameters: &Parameters) -> Self {
        Self {
            norm_1: ChannelNorm::new(&format!("{name}.norm_1"), parameters),
            conv_1: Conv3::new(&format!("{name}.conv_1"), [channels; 2], parameters),
            norm_2: ChannelNorm::new(&format!("{name}.norm_2"), parameters),
            conv_2: map(&format!("{name}.conv_2.weight"), [channels; 2], parameters),
        }
    }

    /// # Shapes
    /// `[T, B, C]` to the same, of `steps` T.
    pub fn forward(&self, x: Vec<f32>, steps: usize) -> (Vec<f32>, ResBlockPass) {
        let first = relu(self.norm_1.forward(&x));
        let between = self.conv_1.forward(&first, steps);
        let second = relu(self.norm_2.forward(&between));
        let mut out = self.conv_2.forward(&second);
        add(&mut out, &x);
        (out, ResBlockPass { x, first, between, second })
    }

    /// Returns the gradient by x, from the one by the output; adds those of the parameters.
    pub fn backward(&self, pass: &ResBlockPass, mut gradient: Vec<f32>, steps: usize, sums: &mut [f32]) -> Vec<f32> {
        let ResBlockPass { x, first, between, second } = pass;
        let by_second = through_relu(self.conv_2.backward(second, &gradient, sums), second);
        let by_between = self.norm_2.backward(between, &by_second, sums);
        let by_first = through_relu(self.conv_1.backward(first, &by_between, steps, sums), first);
        add(&mut gradient, &self.norm_1.backward(x, &by_first, sums));
        gradient
    }
}

/// Returns a number where it is above zero, else zero.
pub fn relu(mut x: Vec<f32>) -> Vec<f32> {
    x.iter_mut().for_each(|x| *x = x.max(0.0));
    x
}

/// Returns the gradient below a [`relu`], from the one above and what came out of it.
pub fn through_relu(mut gradient: Vec<f32>, output: &[f32]) -> Vec<f32> {
    for (gradient, output) in gradient.iter_mut().zip(output) {
        if *output <= 0.0 {
            *gradient = 0.0;
        }
    }
    gradient
}

/// Returns rows with the first two axes exchanged.
///
/// # Shapes
/// `[A, B, C]` to `[B, A, C]`.
pub fn swapped(x: &[f32], [a, b, c]: [usize; 3]) -> Vec<f32> {
    let mut out = Vec::with_capacity(x.len());
    for second in 0..b {
        for first in 0..a {
            out.extend_from_slice(&x[(first * b + second) * c..][..c]);
        }
    }
    out
}

fn map(weight: &str, shape: [usize; 2], parameters: &Parameters) -> Linear {
    Linear::without_bias(weight, shape, parameters.layout(), parameters.values())
}
