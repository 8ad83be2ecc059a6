//! One-dimensional convolutions over time, channels last, and the residual block of the thesis' motion prior (4.3.1).
//!
//! Tensors are `[B, T, C]`, inside residual blocks `[T, B, C]`. Convolutions are written as matrix products, so the time
//! goes into the backend's best kernel, and layer normalization (over channels) needs no transposition.

use burn::module::{Module, Param};
use burn::tensor::activation::relu;
use burn::tensor::module::layer_norm;
use burn::tensor::{Device, Tensor};

use crate::init;
use lifelike_checkpoint::rng;

/// PyTorch's default.
const EPSILON: f64 = 1e-5;

/// Layer normalization over channels (Ba et al. 2016) with a gain and no bias.
#[derive(Module, Debug)]
pub struct ChannelNorm {
    gain: Param<Tensor<1>>,
}

impl ChannelNorm {
    /// Gain 1 for `channels`.
    pub fn new(channels: usize, device: &Device) -> Self {
        Self { gain: init::parameter(vec![1.0; channels], [channels], device) }
    }

    /// # Shapes
    /// `[.., .., C]` to the same.
    pub fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        layer_norm(x, self.gain.val(), None, EPSILON)
    }
}

/// A convolution with kernel 3, stride 1, zero padding 1, no bias, on TIME-MAJOR tensors `[T, B, C]`.
///
/// With time first, shifting by one step is a contiguous slice: each tap is one matrix product of everything, and the
/// outer taps' results are added one step later or earlier. Gathering taps before the product instead copies every
/// activation six times over (it took 40% of a training step).
///
/// `weight_K` is `[Cin, Cout]`: tap 0 looks one step back, tap 1 at the step itself, tap 2 one step ahead.
#[derive(Module, Debug)]
pub struct Conv3 {
    weight_0: Param<Tensor<2>>,
    weight_1: Param<Tensor<2>>,
    weight_2: Param<Tensor<2>>,
}

impl Conv3 {
    /// Uniform weights from the streams `(seed, purpose.K, 0, 0)`.
    pub fn new(inputs: usize, outputs: usize, seed: u64, purpose: &str, device: &Device) -> Self {
        let tap = |k: usize| weight(inputs, outputs, 3 * inputs, 1.0, seed, &format!("{purpose}.{k}"), device);
        Self { weight_0: tap(0), weight_1: tap(1), weight_2: tap(2) }
    }

    /// # Shapes
    /// `[T, B, Cin]` to `[T, B, Cout]`.
    pub fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        let [t, b, _] = x.dims();
        let here = product(x.clone(), self.weight_1.val());
        if t < 2 {
            return here;
        }
        let late = product(x.clone().narrow(0, 0, t - 1), self.weight_0.val());
        let early = product(x.narrow(0, 1, t - 1), self.weight_2.val());
        let zeros = Tensor::zeros([1, b, here.dims()[2]], &here.device());
        here + Tensor::cat(vec![zeros.clone(), late], 0) + Tensor::cat(vec![early, zeros], 0)
    }
}

/// A convolution with kernel 1: the same linear map at every time step, no bias; any order of time and batch.
#[derive(Module, Debug)]
pub struct Conv1 {
    weight: Param<Tensor<2>>,
}

impl Conv1 {
    /// Uniform weights from the stream `(seed, purpose, 0, 0)`.
    pub fn new(inputs: usize, outputs: usize, seed: u64, purpose: &str, device: &Device) -> Self {
        Self { weight: weight(inputs, outputs, inputs, 1.0, seed, purpose, device) }
    }

    /// # Shapes
    /// `[.., .., Cin]` to `[.., .., Cout]`.
    pub fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        product(x, self.weight.val())
    }
}

/// Halves the number of time steps: kernel 4, stride 2, zero padding 1, no bias. T must be even.
///
/// `weight` is `[4 Cin, Cout]`: tap by tap, earliest first.
#[derive(Module, Debug)]
pub struct Down {
    weight: Param<Tensor<2>>,
}

impl Down {
    /// Uniform weights from the stream `(seed, purpose, 0, 0)`.
    pub fn new(inputs: usize, outputs: usize, seed: u64, purpose: &str, device: &Device) -> Self {
        Self { weight: weight(4 * inputs, outputs, 4 * inputs, 1.0, seed, purpose, device) }
    }

    /// # Shapes
    /// `[B, T, Cin]` to `[B, T/2, Cout]`.
    pub fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        let [b, t, c] = x.dims();
        // Steps in pairs: an output sees its own pair (padded by one) and the next.
        let pairs = pad_time(x, 1, 1).reshape([b, t / 2 + 1, 2 * c]);
        let taps = vec![pairs.clone().narrow(1, 0, t / 2), pairs.narrow(1, 1, t / 2)];
        product(Tensor::cat(taps, 2), self.weight.val())
    }
}

/// Doubles the number of time steps: the transpose of [`Down`], no bias.
///
/// `weight` is `[Cin, 4 Cout]`: tap by tap, earliest first.
#[derive(Module, Debug)]
pub struct Up {
    weight: Param<Tensor<2>>,
}

impl Up {
    /// With weights of zero, for a layer that begins by adding nothing.
    #[must_use]
    pub fn zeros(&self, device: &Device) -> Self {
        let [rows, columns] = self.weight.dims();
        Self { weight: init::parameter(vec![0.0; rows * columns], [rows, columns], device) }
    }

    /// Uniform weights from the stream `(seed, purpose, 0, 0)`.
    pub fn new(inputs: usize, outputs: usize, seed: u64, purpose: &str, device: &Device) -> Self {
        // Every output step receives two of the four taps.
        Self { weight: weight(inputs, 4 * outputs, 2 * inputs, 1.0, seed, purpose, device) }
    }

    /// # Shapes
    /// `[B, T, Cin]` to `[B, 2T, Cout]`.
    pub fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        let [b, t, _] = x.dims();
        let taps = product(x, self.weight.val());
        let pair = taps.dims()[2] / 2;
        let early = pad_time(taps.clone().narrow(2, 0, pair), 0, 1);
        let late = pad_time(taps.narrow(2, pair, pair), 1, 0);
        (early + late).reshape([b, 2 * t + 2, pair / 2]).narrow(1, 1, 2 * t)
    }
}

/// The residual block: x + conv1(relu(norm(conv3(relu(norm(x)))))), after Dhariwal et al. 2020's `ResConv1DBlock` (ReLU,
/// kernel 3, ReLU, kernel 1) with the thesis' layer normalization before each ReLU and without biases.
#[derive(Module, Debug)]
pub struct ResBlock {
    norm_1: ChannelNorm,
    conv_1: Conv3,
    norm_2: ChannelNorm,
    conv_2: Conv1,
}

impl ResBlock {
    /// Returns a block of `channels`; the streams are addressed by `purpose`.
    pub fn new(channels: usize, seed: u64, purpose: &str, device: &Device) -> Self {
        Self {
            norm_1: ChannelNorm::new(channels, device),
            conv_1: Conv3::new(channels, channels, seed, &format!("{purpose}.conv_1"), device),
            norm_2: ChannelNorm::new(channels, device),
            conv_2: Conv1::new(channels, channels, seed, &format!("{purpose}.conv_2"), device),
        }
    }

    /// # Shapes
    /// `[T, B, C]` to the same.
    pub fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        let y = self.conv_1.forward(relu(self.norm_1.forward(x.clone())));
        let y = self.conv_2.forward(relu(self.norm_2.forward(y)));
        x + y
    }
}

fn weight(
    rows: usize,
    columns: usize,
    fan_in: usize,
    gain: f64,
    seed: u64,
    purpose: &str,
    device: &Device,
) -> Param<Tensor<2>> {
    let values = init::uniform_by_fan_in(&mut rng::stream(seed, purpose, 0, 0), rows * columns, fan_in, gain);
    init::parameter(values, [rows, columns], device)
}

/// Zeros before and after in time.
pub fn pad_time(x: Tensor<3>, before: usize, after: usize) -> Tensor<3> {
    let [b, _, c] = x.dims();
    let zeros = |n: usize| Tensor::zeros([b, n, c], &x.device());
    let mut parts = Vec::with_capacity(3);
    if before > 0 {
        parts.push(zeros(before));
    }
    parts.push(x.clone());
    if after > 0 {
        parts.push(zeros(after));
    }
    Tensor::cat(parts, 1)
}

fn product(x: Tensor<3>, weight: Tensor<2>) -> Tensor<3> {
    let [b, t, c] = x.dims();
    let columns = weight.dims()[1];
    x.reshape([b * t, c]).matmul(weight).reshape([b, t, columns])
}
