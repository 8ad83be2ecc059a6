//! The gradient of a [`SplineAutoencoder`] by hand, for training on a CPU. Automatic differentiation writes every
//! intermediate result of every operation to memory, in one thread; it stays the way on a card, and tests hold this against
//! it and against PyTorch.
//!
//! Products with weights are those of [`crate::rows`]; attention, normalization and GELU are loops over our own memory. A pass is one
//! thread's work: who has several cores gives each its part of a batch, and shares the packed [`Weights`] among them.
//! `cargo run --release -p lifelike-nn --example transformer` measures it beside automatic differentiation
//! (`docs/results/transformer-speed.md`).

pub(super) mod attention;
mod linear;
mod norm;
mod places;
mod softmax;
mod stack;

use std::ops::Range;

use burn::tensor::{Device, Tensor, TensorData};

use super::autoencoder::{SplineAutoencoder, positions};
use super::latent::LatentTokens;
use super::sampling::Sampling;
use crate::gradients::Gradients;
use crate::numbers::{Unreadable, read};
use crate::rows::{activated, add};
use crate::spline::SplineError;
use linear::Linear;
use places::Places;
use stack::{Stack, StackPass};

/// A pass that cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum PassError {
    /// Tensor data that cannot be read from the device.
    #[error(transparent)]
    Unreadable(#[from] Unreadable),
    /// The latent tokens cannot be made.
    #[error(transparent)]
    Spline(#[from] SplineError),
    /// An array that does not fit the network or the pass.
    #[error("{what}: expected a multiple of {unit} numbers, got {got}")]
    Size {
        /// The array.
        what: &'static str,
        /// Numbers of one sequence.
        unit: usize,
        /// The size found.
        got: usize,
    },
}

/// Output of a network for a batch.
#[derive(Debug, Clone)]
pub struct Output {
    /// `[B, P, d]`, row-major.
    pub control_points: Vec<f32>,
    /// `[B, T, inputs]`, row-major.
    pub sequence: Vec<f32>,
}

/// Numbers of the forward pass that the backward one needs: 7 for each token, width and block, and
/// attention's weights, one for each two tokens of each head.
#[derive(Debug, Clone)]
pub struct AutoencoderPass {
    batch: usize,
    x: Vec<f32>,
    hidden: Vec<f32>,
    encoder: StackPass,
    control_tokens: Vec<f32>,
    latent: Tensor<3>,
    tokens: Tensor<3>,
    decoder: StackPass,
    decoded: Vec<f32>,
}

/// A network's numbers as passes read them: taken and packed once, then used for every part of a batch.
#[derive(Debug, Clone)]
pub struct Weights {
    places: Places,
    /// Embedding of inputs: hidden, output.
    input: [Linear; 2],
    inputs: usize,
    /// Where the control tokens `[P, c]` stand.
    control: Range<usize>,
    encoder: Stack,
    to_latent: Linear,
    from_latent: Linear,
    decoder: Stack,
    output: Linear,
    tokens: LatentTokens,
    device: Device,
}

impl Weights {
    /// Takes the numbers of a network.
    ///
    /// # Errors
    /// Tensor data that cannot be read from the device.
    pub fn of(network: &SplineAutoencoder) -> Result<Self, Unreadable> {
        let places = Places::of(network)?;
        let ([inputs, c], d) = (network.input.hidden.weight.dims(), network.to_latent.bias.dims()[0]);
        let stack = |name: &str, layers: usize, width: usize| Stack::new(&places, name, layers, width, network.heads);
        let wide = network.tokens.decoder_width(c);
        Ok(Self {
            input: [Linear::affine(&places, "input.hidden", inputs), Linear::affine(&places, "input.output", c)],
            inputs,
            control: places.range("control"),
            encoder: stack("encoder", network.encoder.blocks.len(), c),
            to_latent: Linear::affine(&places, "to_latent", c),
            from_latent: Linear::affine(&places, "from_latent", network.tokens.width(d)),
            decoder: stack("decoder", network.decoder.blocks.len(), wide),
            output: Linear::affine(&places, "output", wide),
            tokens: network.tokens.clone(),
            device: network.control.val().device().inner(),
            places,
        })
    }

    /// As [`SplineAutoencoder::forward`], outside of automatic differentiation.
    ///
    /// # Shapes
    /// `x: [B, T, inputs]`, row-major, with T = `tokens`.
    ///
    /// # Errors
    /// `x` does not hold whole sequences, or tensor data that cannot be read from the device.
    pub fn forward(&self, x: Vec<f32>, tokens: usize) -> Result<(Output, AutoencoderPass), PassError> {
        let (points, c, d) = (self.points(), self.width(), self.to_latent.outputs());
        let unit = tokens * self.inputs;
        if unit == 0 || x.is_empty() || !x.len().is_multiple_of(unit) {
            return Err(PassError::Size { what: "sequences", unit, got: x.len() });
        }
        let batch = x.len() / unit;

        let hidden = self.input[0].forward(&x);
        let embedded = self.input[1].forward(&activated(&hidden));
        let mut all = Vec::with_capacity(batch * (points + tokens) * c);
        for sequence in embedded.chunks_exact(tokens * c) {
            all.extend_from_slice(self.places.values(self.control.clone()));
            all.extend_from_slice(sequence);
        }
        let (encoded, encoder) = self.encoder.forward(all, &positions(points, tokens));
        let heads_of_rows = encoded.chunks_exact((points + tokens) * c).flat_map(|rows| &rows[..points * c]);
        let control_tokens: Vec<f32> = heads_of_rows.copied().collect();
        let control_points = self.to_latent.forward(&control_tokens);

        // The latent step is small, and the one that differs between methods: automatic differentiation does it.
        let device = self.device.clone().autodiff();
        let sampling = Sampling::each(tokens);
        let latent = Tensor::<3>::from_data(TensorData::new(control_points.clone(), [batch, points, d]), &device);
        let latent = latent.require_grad();
        let tokens = self.tokens.tokens(latent.clone(), &sampling)?;
        let decoder_in = self.from_latent.forward(&read(tokens.clone().inner())?);
        let (decoded, decoder) = self.decoder.forward(decoder_in, sampling.positions());
        let sequence = self.output.forward(&decoded);
        let pass = AutoencoderPass { batch, x, hidden, encoder, control_tokens, latent, tokens, decoder, decoded };
        Ok((Output { control_points, sequence }, pass))
    }

    /// Gradients of all parameters, in one row: see [`Self::named`].
    ///
    /// # Shapes
    /// The loss's derivative by each number of [`Output::sequence`], and by each of [`Output::control_points`] where the
    /// loss has a term of them.
    ///
    /// # Errors
    /// Gradients of another size than the outputs, or tensor data that cannot be read from the device.
    pub fn backward(
        &self,
        pass: AutoencoderPass,
        by_sequence: &[f32],
        by_control_points: Option<&[f32]>,
    ) -> Result<Vec<f32>, PassError> {
        let AutoencoderPass { batch, x, hidden, encoder, control_tokens, latent, tokens, decoder, decoded } = pass;
        let (points, c, steps) = (self.points(), self.width(), x.len() / batch / self.inputs);
        let latents = latent.shape().num_elements();
        let sizes = [
            ("gradients by the sequence", by_sequence.len(), x.len()),
            ("gradients by the control points", by_control_points.map_or(latents, <[f32]>::len), latents),
        ];
        if let Some((what, got, unit)) = sizes.into_iter().find(|(_, got, expected)| got != expected) {
            return Err(PassError::Size { what, unit, got });
        }
        let mut sums = vec![0.0; self.places.len()];

        let gradient = self.output.backward(&decoded, by_sequence, &mut sums);
        let gradient = self.decoder.backward(decoder, gradient, &mut sums);
        let gradient = self.from_latent.backward(&read(tokens.clone().inner())?, &gradient, &mut sums);
        let gradient = Tensor::<3>::from_data(TensorData::new(gradient, tokens.dims()), &tokens.device());
        let mut tape = (tokens * gradient).sum().backward();
        let mut gradient = match latent.grad_remove(&mut tape) {
            Some(gradient) => read(gradient)?,
            None => vec![0.0; latents],
        };
        if let Some(more) = by_control_points {
            add(&mut gradient, more);
        }
        let gradient = self.to_latent.backward(&control_tokens, &gradient, &mut sums);

        // Only the control tokens' outputs were read.
        let mut by_encoded = vec![0.0; batch * (points + steps) * c];
        let rows = by_encoded.chunks_exact_mut((points + steps) * c);
        rows.zip(gradient.chunks_exact(points * c))
            .for_each(|(rows, gradient)| rows[..points * c].copy_from_slice(gradient));
        let gradient = self.encoder.backward(encoder, by_encoded, &mut sums);
        let mut by_embedded = Vec::with_capacity(batch * steps * c);
        for rows in gradient.chunks_exact((points + steps) * c) {
            add(&mut sums[self.control.clone()], &rows[..points * c]);
            by_embedded.extend_from_slice(&rows[points * c..]);
        }
        let mut gradient = self.input[1].by_input(&by_embedded);
        let hidden = stack::through_gelu(&hidden, &mut gradient);
        self.input[1].learn(&hidden, &by_embedded, &mut sums);
        self.input[0].learn(&x, &gradient, &mut sums);
        Ok(sums)
    }

    /// Returns a row of gradients, of one part or the sum of several, by their parameters' names.
    pub fn named(&self, sums: &[f32]) -> Gradients {
        self.places.named(sums, &self.device)
    }

    /// c.
    fn width(&self) -> usize {
        self.input[1].outputs()
    }

    /// P.
    fn points(&self) -> usize {
        self.control.len() / self.width().max(1)
    }
}
