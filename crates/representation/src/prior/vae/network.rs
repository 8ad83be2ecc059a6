//! The convolutional β-VAE of thesis 4.2.1 and 4.3.1.
//!
//! ```text
//! [B, 61, F] -> pad to 64 -> Down, ReLU, Down -> 4 residual blocks -> LayerNorm, ReLU -> linear -> μ, log σ²  [B, d_z]
//! [B, d_z] -> linear -> 4 residual blocks -> LayerNorm, ReLU -> Up, ReLU, Up -> crop -> [B, 61, F]
//! ```
//!
//! With a linear path ([`VaePlan::linear_path`]) principal components stand beside both directions, fixed: μ is the window's components
//! plus what the encoder adds, the decoded window that of the components plus what the decoder adds. Both begin by adding nothing.
//!
//! `Down` and `Up` are strided convolutions and their transposes (kernel 4, stride 2). The thesis leaves kernel sizes and
//! strides open; two halvings keep most of the work in the blocks at 16 time steps.

use burn::module::Module;
use burn::nn::Linear;
use burn::tensor::activation::relu;
use burn::tensor::{Device, Tensor};
use lifelike_checkpoint::rng;
use lifelike_nn::conv_resnet::{ChannelNorm, Down, ResBlock, Up, pad_time};
use lifelike_nn::init;

use super::plan::VaePlan;
use crate::components::Components;

/// Name of the network in files.
pub(super) const NETWORK: &str = "vae";

/// Time steps are halved this often.
const HALVINGS: usize = 2;

/// Encoder e_ψ and decoder d_φ.
#[derive(Module, Debug)]
pub struct MotionVae {
    encoder_in: Down,
    encoder_down: Down,
    encoder_blocks: Vec<ResBlock>,
    encoder_norm: ChannelNorm,
    encoder_out: Linear,
    decoder_in: Linear,
    decoder_blocks: Vec<ResBlock>,
    decoder_norm: ChannelNorm,
    decoder_up: Up,
    decoder_out: Up,
    /// Not learned, and not in the module's own arrays.
    #[module(skip)]
    linear_path: Option<Components>,
    #[module(skip)]
    samples: usize,
    #[module(skip)]
    channels: usize,
    #[module(skip)]
    latent: usize,
}

impl MotionVae {
    /// Returns a network for windows of `features` numbers per sample, with weights from the plan's seed.
    pub fn new(plan: &VaePlan, features: usize, device: &Device) -> Self {
        let (c, seed) = (plan.channels, plan.windows.seed);
        let samples = 2 * plan.windows.half_width + 1;
        let flat = c * steps(samples);
        let blocks = |side: &str| {
            (0..plan.blocks).map(|i| ResBlock::new(c, seed, &format!("prior.{side}.block{i}"), device)).collect()
        };
        let network = Self {
            encoder_in: Down::new(features, c, seed, "prior.encoder_in", device),
            encoder_down: Down::new(c, c, seed, "prior.encoder_down", device),
            encoder_blocks: blocks("encoder"),
            encoder_norm: ChannelNorm::new(c, device),
            encoder_out: linear(flat, 2 * plan.latent, seed, "prior.encoder_out", device),
            decoder_in: linear(plan.latent, flat, seed, "prior.decoder_in", device),
            decoder_blocks: blocks("decoder"),
            decoder_norm: ChannelNorm::new(c, device),
            decoder_up: Up::new(c, c, seed, "prior.decoder_up", device),
            decoder_out: Up::new(c, features, seed, "prior.decoder_out", device),
            linear_path: None,
            samples,
            channels: c,
            latent: plan.latent,
        };
        if plan.linear_path { network.adding_nothing(device) } else { network }
    }

    /// With outputs of zero, so that a linear path is what it begins with.
    fn adding_nothing(mut self, device: &Device) -> Self {
        let [rows, columns] = self.encoder_out.weight.dims();
        self.encoder_out.weight = init::parameter(vec![0.0; rows * columns], [rows, columns], device);
        self.decoder_out = self.decoder_out.zeros(device);
        self
    }

    /// With principal components beside encoder and decoder.
    #[must_use]
    pub(super) fn with_linear_path(self, components: Components) -> Self {
        Self { linear_path: Some(components), ..self }
    }

    /// Principal components beside encoder and decoder, if there are any.
    pub(super) fn linear_path(&self) -> Option<&Components> {
        self.linear_path.as_ref()
    }

    /// Returns d_z.
    pub fn latent_size(&self) -> usize {
        self.latent
    }

    /// Returns mean and log variance of the latent.
    ///
    /// # Shapes
    /// `[B, 2W + 1, F]` to two `[B, d_z]`.
    pub fn encode(&self, x: Tensor<3>) -> (Tensor<2>, Tensor<2>) {
        let [b, t, f] = x.dims();
        let (before, after) = padding(self.samples);
        let linear = self.linear_path.as_ref().map(|components| components.codes(x.clone().reshape([b, t * f])));
        let x = relu(self.encoder_in.forward(pad_time(x, before, after)));
        let x = through(&self.encoder_blocks, self.encoder_down.forward(x));
        let x = relu(self.encoder_norm.forward(x)).reshape([b, self.channels * steps(self.samples)]);
        let out = self.encoder_out.forward(x);
        let mean = out.clone().narrow(1, 0, self.latent);
        (linear.map_or(mean.clone(), |linear| linear + mean), out.narrow(1, self.latent, self.latent))
    }

    /// Returns the window of a latent.
    ///
    /// # Shapes
    /// `[B, d_z]` to `[B, 2W + 1, F]`.
    pub fn decode(&self, z: Tensor<2>) -> Tensor<3> {
        let [b, _] = z.dims();
        let linear = self.linear_path.as_ref().map(|components| components.rows(z.clone()));
        let x = self.decoder_in.forward(z).reshape([b, steps(self.samples), self.channels]);
        let x = through(&self.decoder_blocks, x);
        let x = relu(self.decoder_norm.forward(x));
        let x = self.decoder_out.forward(relu(self.decoder_up.forward(x)));
        let x = x.narrow(1, padding(self.samples).0, self.samples);
        let shape = x.dims();
        linear.map_or(x.clone(), |linear| linear.reshape(shape) + x)
    }
}

/// Returns the residual blocks work on `[T, B, C]`.
fn through(blocks: &[ResBlock], x: Tensor<3>) -> Tensor<3> {
    blocks.iter().fold(x.swap_dims(0, 1), |x, block| block.forward(x)).swap_dims(0, 1)
}

/// Time steps between encoder and decoder.
fn steps(samples: usize) -> usize {
    samples.div_ceil(1 << HALVINGS)
}

/// Zeros before and after a window, so that it can be halved.
fn padding(samples: usize) -> (usize, usize) {
    let missing = (steps(samples) << HALVINGS) - samples;
    (missing / 2, missing - missing / 2)
}

fn linear(inputs: usize, outputs: usize, seed: u64, purpose: &str, device: &Device) -> Linear {
    let mut rng = rng::stream(seed, purpose, 0, 0);
    let weight = init::uniform_by_fan_in(&mut rng, inputs * outputs, inputs, 1.0 / 3f64.sqrt());
    Linear {
        weight: init::parameter(weight, [inputs, outputs], device),
        bias: Some(init::parameter(vec![0.0; outputs], [outputs], device)),
    }
}
