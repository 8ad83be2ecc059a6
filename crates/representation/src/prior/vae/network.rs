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

use lifelike_checkpoint::rng;
use lifelike_nn::conv_resnet::{
    ChannelNorm, Down, ResBlock, ResBlockPass, Up, add_block, add_down, add_norm, add_up, relu, swapped, through_relu,
};
use lifelike_nn::init;
use lifelike_nn::parameters::{ParameterList, Parameters};
use lifelike_nn::rows::{Linear, add};

use super::plan::VaePlan;
use crate::components::Components;

/// Name of the network in files.
pub(super) const NETWORK: &str = "vae";

/// Time steps are halved this often.
const HALVINGS: usize = 2;

/// Encoder e_ψ and decoder d_φ.
#[derive(Debug, Clone)]
pub struct MotionVae {
    sizes: Sizes,
    parameters: Parameters,
    /// Not learned, and not among the parameters.
    linear_path: Option<Components>,
}

#[derive(Debug, Clone, Copy)]
struct Sizes {
    /// 2W + 1: samples of a window.
    samples: usize,
    /// F: numbers of a sample.
    features: usize,
    channels: usize,
    blocks: usize,
    /// d_z.
    latent: usize,
}

impl Sizes {
    /// Time steps between encoder and decoder.
    fn steps(&self) -> usize {
        self.samples.div_ceil(1 << HALVINGS)
    }

    /// Time steps of a padded window.
    fn padded(&self) -> usize {
        self.steps() << HALVINGS
    }

    /// Zeros before a window.
    fn before(&self) -> usize {
        (self.padded() - self.samples) / 2
    }
}

impl MotionVae {
    /// Returns a network for windows of `features` numbers per sample, with weights from the plan's seed.
    pub fn new(plan: &VaePlan, features: usize) -> Self {
        let VaePlan { channels, blocks, latent, .. } = *plan;
        let sizes = Sizes { samples: 2 * plan.windows.half_width + 1, features, channels, blocks, latent };
        let (c, seed) = (channels, plan.windows.seed);
        let flat = c * sizes.steps();
        let mut list = ParameterList::default();
        add_down(&mut list, "encoder_in", [features, c], seed, "prior.encoder_in");
        add_down(&mut list, "encoder_down", [c, c], seed, "prior.encoder_down");
        add_blocks(&mut list, "encoder", sizes, seed);
        add_norm(&mut list, "encoder_norm", c);
        add_linear(&mut list, "encoder_out", [flat, 2 * latent], seed);
        add_linear(&mut list, "decoder_in", [latent, flat], seed);
        add_blocks(&mut list, "decoder", sizes, seed);
        add_norm(&mut list, "decoder_norm", c);
        add_up(&mut list, "decoder_up", [c, c], seed, "prior.decoder_up");
        add_up(&mut list, "decoder_out", [c, features], seed, "prior.decoder_out");
        let mut parameters = list.finish();
        if plan.linear_path {
            // With outputs of zero, the linear path is what it begins with.
            parameters.get_mut("encoder_out.weight").fill(0.0);
            parameters.get_mut("decoder_out.weight").fill(0.0);
        }
        Self { sizes, parameters, linear_path: None }
    }

    /// Returns the parameters of encoder and decoder.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    pub(super) fn parameters_mut(&mut self) -> &mut Parameters {
        &mut self.parameters
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
        self.sizes.latent
    }

    /// Packs the parameters for passes.
    pub(super) fn weights(&self) -> VaeWeights<'_> {
        let (p, Sizes { features, channels: c, latent, .. }) = (&self.parameters, self.sizes);
        let flat = c * self.sizes.steps();
        let blocks =
            |side: &str| (0..self.sizes.blocks).map(|i| ResBlock::new(&format!("{side}_blocks.{i}"), c, p)).collect();
        VaeWeights {
            sizes: self.sizes,
            linear_path: self.linear_path.as_ref(),
            encoder_in: Down::new("encoder_in", [features, c], p),
            encoder_down: Down::new("encoder_down", [c, c], p),
            encoder_blocks: blocks("encoder"),
            encoder_norm: ChannelNorm::new("encoder_norm", p),
            encoder_out: Linear::new("encoder_out", [flat, 2 * latent], p.layout(), p.values()),
            decoder_in: Linear::new("decoder_in", [latent, flat], p.layout(), p.values()),
            decoder_blocks: blocks("decoder"),
            decoder_norm: ChannelNorm::new("decoder_norm", p),
            decoder_up: Up::new("decoder_up", [c, c], p),
            decoder_out: Up::new("decoder_out", [c, features], p),
        }
    }
}

fn add_blocks(list: &mut ParameterList, side: &str, sizes: Sizes, seed: u64) {
    for i in 0..sizes.blocks {
        add_block(list, &format!("{side}_blocks.{i}"), sizes.channels, seed, &format!("prior.{side}.block{i}"));
    }
}

fn add_linear(list: &mut ParameterList, name: &str, [inputs, outputs]: [usize; 2], seed: u64) {
    let mut rng = rng::stream(seed, &format!("prior.{name}"), 0, 0);
    let weight = init::uniform_by_fan_in(&mut rng, inputs * outputs, inputs, 1.0 / 3f64.sqrt());
    list.add(format!("{name}.weight"), &[inputs, outputs], weight);
    list.add(format!("{name}.bias"), &[outputs], vec![0.0; outputs]);
}

/// The network with its parameters packed. A pass is one thread's work.
#[derive(Debug)]
pub(super) struct VaeWeights<'a> {
    sizes: Sizes,
    linear_path: Option<&'a Components>,
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
}

/// Parameters of the normal distributions of latents.
#[derive(Debug, Clone)]
pub(super) struct Encoded {
    /// `[B, d_z]`.
    pub(super) mean: Vec<f32>,
    /// `[B, d_z]`.
    pub(super) log_variance: Vec<f32>,
}

/// Numbers that the encoder's backward pass needs; all time-major but `flat`.
#[derive(Debug)]
pub(super) struct EncoderPass {
    padded: Vec<f32>,
    first: Vec<f32>,
    blocks: Vec<ResBlockPass>,
    last: Vec<f32>,
    flat: Vec<f32>,
}

/// Numbers that the decoder's backward pass needs.
#[derive(Debug)]
pub(super) struct DecoderPass {
    z: Vec<f32>,
    blocks: Vec<ResBlockPass>,
    last: Vec<f32>,
    normed: Vec<f32>,
    up: Vec<f32>,
}

impl VaeWeights<'_> {
    /// Returns mean and log variance of the latent.
    ///
    /// # Shapes
    /// `[B, 2W + 1, F]` to two `[B, d_z]`.
    pub(super) fn encode(&self, windows: &[f32]) -> (Encoded, EncoderPass) {
        let Sizes { samples, features, channels, latent, .. } = self.sizes;
        let batch = windows.len() / (samples * features);
        let (long, steps) = (self.sizes.padded(), self.sizes.steps());
        let mut padded = vec![0.0; long * batch * features];
        let first = self.sizes.before() * batch * features;
        padded[first..first + windows.len()].copy_from_slice(&swapped(windows, [batch, samples, features]));

        let first = relu(self.encoder_in.forward(&padded, long));
        let down = self.encoder_down.forward(&first, long / 2);
        let (last, blocks) = through(&self.encoder_blocks, down, steps);
        let flat = swapped(&relu(self.encoder_norm.forward(&last)), [steps, batch, channels]);
        let out = self.encoder_out.forward(&flat);
        let half = |from: usize| -> Vec<f32> {
            out.chunks_exact(2 * latent).flat_map(|row| &row[from..from + latent]).copied().collect()
        };
        let (mut mean, log_variance) = (half(0), half(latent));
        if let Some(components) = self.linear_path {
            add(&mut mean, &components.encode(windows));
        }
        (Encoded { mean, log_variance }, EncoderPass { padded, first, blocks, last, flat })
    }

    /// Adds the encoder's gradients, from those by mean and log variance.
    pub(super) fn encode_backward(&self, pass: EncoderPass, by: &Encoded, sums: &mut [f32]) {
        let Sizes { channels, latent, .. } = self.sizes;
        let (long, steps) = (self.sizes.padded(), self.sizes.steps());
        let batch = by.mean.len() / latent;
        let EncoderPass { padded, first, blocks, last, flat } = pass;
        let rows = by.mean.chunks_exact(latent).zip(by.log_variance.chunks_exact(latent));
        let by_out: Vec<f32> = rows.flat_map(|(mean, log_variance)| mean.iter().chain(log_variance)).copied().collect();
        let by_flat = through_relu(self.encoder_out.backward(&flat, &by_out, sums), &flat);
        let by_normed = swapped(&by_flat, [batch, steps, channels]);
        let gradient = self.encoder_norm.backward(&last, &by_normed, sums);
        let gradient = back_through(&self.encoder_blocks, &blocks, gradient, steps, sums);
        let gradient = through_relu(self.encoder_down.backward(&first, &gradient, long / 2, sums), &first);
        self.encoder_in.backward(&padded, &gradient, long, sums);
    }

    /// Returns the windows of latents.
    ///
    /// # Shapes
    /// `[B, d_z]` to `[B, 2W + 1, F]`.
    pub(super) fn decode(&self, z: Vec<f32>) -> (Vec<f32>, DecoderPass) {
        let Sizes { samples, features, channels, latent, .. } = self.sizes;
        let (batch, steps) = (z.len() / latent, self.sizes.steps());
        let x = swapped(&self.decoder_in.forward(&z), [batch, steps, channels]);
        let (last, blocks) = through(&self.decoder_blocks, x, steps);
        let normed = relu(self.decoder_norm.forward(&last));
        let up = relu(self.decoder_up.forward(&normed, steps));
        let long = self.decoder_out.forward(&up, 2 * steps);
        let first = self.sizes.before() * batch * features;
        let mut out = swapped(&long[first..first + samples * batch * features], [samples, batch, features]);
        if let Some(components) = self.linear_path {
            add(&mut out, &components.decode(&z));
        }
        (out, DecoderPass { z, blocks, last, normed, up })
    }

    /// Adds the decoder's gradients, from that by the windows; returns the gradient by the latents.
    pub(super) fn decode_backward(&self, pass: DecoderPass, by_windows: &[f32], sums: &mut [f32]) -> Vec<f32> {
        let Sizes { samples, features, channels, .. } = self.sizes;
        let DecoderPass { z, blocks, last, normed, up } = pass;
        let (batch, steps) = (z.len() / self.sizes.latent, self.sizes.steps());
        let mut by_long = vec![0.0; self.sizes.padded() * batch * features];
        let first = self.sizes.before() * batch * features;
        by_long[first..first + by_windows.len()].copy_from_slice(&swapped(by_windows, [batch, samples, features]));
        let by_up = through_relu(self.decoder_out.backward(&up, &by_long, 2 * steps, sums), &up);
        let by_normed = through_relu(self.decoder_up.backward(&normed, &by_up, steps, sums), &normed);
        let gradient = self.decoder_norm.backward(&last, &by_normed, sums);
        let gradient = back_through(&self.decoder_blocks, &blocks, gradient, steps, sums);
        let mut by_z = self.decoder_in.backward(&z, &swapped(&gradient, [steps, batch, channels]), sums);
        if let Some(components) = self.linear_path {
            add(&mut by_z, &components.by_codes(by_windows));
        }
        by_z
    }
}

fn through(blocks: &[ResBlock], mut x: Vec<f32>, steps: usize) -> (Vec<f32>, Vec<ResBlockPass>) {
    let mut passes = Vec::with_capacity(blocks.len());
    for block in blocks {
        let (next, pass) = block.forward(x, steps);
        passes.push(pass);
        x = next;
    }
    (x, passes)
}

fn back_through(
    blocks: &[ResBlock],
    passes: &[ResBlockPass],
    gradient: Vec<f32>,
    steps: usize,
    sums: &mut [f32],
) -> Vec<f32> {
    let all = blocks.iter().zip(passes).rev();
    all.fold(gradient, |gradient, (block, pass)| block.backward(pass, gradient, steps, sums))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_checkpoint::Checkpoint;

    use super::*;
    use crate::prior::WindowPlan;

    const FEATURES: usize = 5;

    fn wave(count: usize, pace: f32) -> Vec<f32> {
        (0..count).map(|i| (i as f32 * pace).sin()).collect()
    }

    fn dot(a: &[f32], b: &[f32]) -> f64 {
        a.iter().zip(b).map(|(a, b)| f64::from(a * b)).sum()
    }

    /// Windows of 13 samples, which padding brings to 16, with principal components beside.
    fn network() -> MotionVae {
        let windows = WindowPlan { half_width: 6, ..WindowPlan::default() };
        let plan = VaePlan { windows, channels: 8, blocks: 2, latent: 3, ..VaePlan::default() };
        let size = 13 * FEATURES;
        let mut file = Checkpoint::new();
        file.put_f32("components.mean", &[size], wave(size, 0.3)).unwrap();
        file.put_f32("components.directions", &[3, size], wave(3 * size, 0.7)).unwrap();
        MotionVae::new(&plan, FEATURES).with_linear_path(Components::read(&file, 3, size).unwrap())
    }

    /// Along the gradient of each parameter a weighed sum of all outputs changes as fast as the gradient is long.
    /// The steps are short, since a rectifier that changes its side within one bends the difference.
    #[test]
    fn gradients_are_those_of_finite_differences() {
        const STEP: f64 = 2e-4;
        let (x, z) = (wave(4 * 13 * FEATURES, 0.37), wave(4 * 3, 1.1));
        let by_windows: Vec<f32> = wave(x.len(), 0.11).into_iter().map(|x| x + 0.5).collect();
        let by = Encoded { mean: wave(12, 0.9), log_variance: wave(12, 0.4) };
        let value = |network: &MotionVae, z: &[f32]| {
            let weights = network.weights();
            let encoded = weights.encode(&x).0;
            let outputs = dot(&encoded.mean, &by.mean) + dot(&encoded.log_variance, &by.log_variance);
            outputs + dot(&weights.decode(z.to_vec()).0, &by_windows)
        };
        let network = network();
        let (weights, mut sums) = (network.weights(), vec![0.0; network.parameters().len()]);
        weights.encode_backward(weights.encode(&x).1, &by, &mut sums);
        let by_z = weights.decode_backward(weights.decode(z.clone()).1, &by_windows, &mut sums);
        for entry in network.parameters().layout().entries() {
            let along = &sums[network.parameters().range(&entry.name)];
            let moved = |step: f64| {
                let mut network = network.clone();
                step_along(network.parameters_mut().get_mut(&entry.name), along, step);
                value(&network, &z)
            };
            assert_slope(&entry.name, (moved(STEP) - moved(-STEP)) / (2.0 * STEP), along);
        }
        let moved = |step: f64| {
            let mut z = z.clone();
            step_along(&mut z, &by_z, step);
            value(&network, &z)
        };
        assert_slope("latents", (moved(STEP) - moved(-STEP)) / (2.0 * STEP), &by_z);
    }

    fn length(x: &[f32]) -> f64 {
        dot(x, x).sqrt()
    }

    fn step_along(values: &mut [f32], along: &[f32], step: f64) {
        let size = length(along);
        values.iter_mut().zip(along).for_each(|(x, along)| *x += (step * f64::from(*along) / size) as f32);
    }

    fn assert_slope(name: &str, slope: f64, gradient: &[f32]) {
        let size = length(gradient);
        assert!((slope - size).abs() < 0.01 * size, "{name}: {slope}, not {size}");
    }
}
