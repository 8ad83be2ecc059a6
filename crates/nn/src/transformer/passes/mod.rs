//! Passes of a [`SplineAutoencoder`], forward and backward.
//!
//! Products with weights are those of [`crate::rows`]; attention, normalization and GELU are loops over our own memory. A pass is one
//! thread's work: who has several cores gives each its part of a batch, and shares the packed [`Weights`] among them.
//! `cargo run --release -p lifelike-nn --example transformer` measures it (`docs/results/transformer-speed.md`).

pub(super) mod attention;
mod norm;
mod softmax;
mod stack;

use std::ops::Range;

use super::autoencoder::{SplineAutoencoder, positions};
use super::latent::LatentTokens;
use super::sampling::Sampling;
use crate::rows::{Linear, activated, add};
use crate::spline::SplineError;
use stack::{Stack, StackPass};

/// A pass that cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum PassError {
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
    tokens: Vec<f32>,
    sampling: Sampling,
    decoder: StackPass,
    decoded: Vec<f32>,
}

/// A network's numbers as passes read them: taken and packed once, then used for every part of a batch.
#[derive(Debug, Clone)]
pub struct Weights {
    /// Embedding of inputs: hidden, output.
    input: [Linear; 2],
    inputs: usize,
    /// The control tokens `[P, c]`, and where they stand in rows of parameters.
    control: (Vec<f32>, Range<usize>),
    encoder: Stack,
    to_latent: Linear,
    from_latent: Linear,
    decoder: Stack,
    output: Linear,
    tokens: LatentTokens,
    /// Parameters of the network.
    count: usize,
}

impl Weights {
    /// Packs the numbers of a network.
    pub fn of(network: &SplineAutoencoder) -> Self {
        let (parameters, config) = (network.parameters(), network.config());
        let (inputs, c, d) = (config.inputs, config.width, config.latent);
        let affine = |name: &str, shape: [usize; 2]| Linear::new(name, shape, parameters.layout(), parameters.values());
        let stack = |name: &str, width: usize| Stack::new(parameters, name, config.layers, width, config.heads);
        let wide = config.tokens.decoder_width(c);
        let control = parameters.range("control");
        Self {
            input: [affine("input.hidden", [inputs, c]), affine("input.output", [c, c])],
            inputs,
            control: (parameters.values()[control.clone()].to_vec(), control),
            encoder: stack("encoder", c),
            to_latent: affine("to_latent", [c, d]),
            from_latent: affine("from_latent", [config.tokens.width(d), wide]),
            decoder: stack("decoder", wide),
            output: affine("output", [wide, inputs]),
            tokens: config.tokens.clone(),
            count: parameters.len(),
        }
    }

    /// Returns the control points of sequences.
    ///
    /// # Shapes
    /// `[B, tokens, inputs]` to `[B, P, d]`.
    ///
    /// # Errors
    /// `x` does not hold whole sequences.
    pub fn encode(&self, x: &[f32], tokens: usize) -> Result<Vec<f32>, PassError> {
        self.check(x.len(), tokens)?;
        Ok(self.encoded(x, tokens).control_points)
    }

    /// Returns the sequences of control points.
    ///
    /// # Shapes
    /// `[B, P, d]` to `[B, sampling, inputs]`.
    ///
    /// # Errors
    /// Numbers that are not whole sequences of control points.
    pub fn decode(&self, control_points: &[f32], sampling: &Sampling) -> Result<Vec<f32>, PassError> {
        let tokens = self.tokens.tokens(control_points, self.to_latent.outputs(), sampling)?;
        let (decoded, _) = self.decoder.forward(self.from_latent.forward(&tokens), sampling.positions());
        Ok(self.output.forward(&decoded))
    }

    /// Both, with the numbers that [`Self::backward`] needs.
    ///
    /// # Shapes
    /// `x: [B, T, inputs]`, row-major, with T = `tokens`.
    ///
    /// # Errors
    /// `x` does not hold whole sequences.
    pub fn forward(&self, x: Vec<f32>, tokens: usize) -> Result<(Output, AutoencoderPass), PassError> {
        let batch = self.check(x.len(), tokens)?;
        let Encoded { hidden, encoder, control_tokens, control_points } = self.encoded(&x, tokens);
        let sampling = Sampling::each(tokens);
        let tokens = self.tokens.tokens(&control_points, self.to_latent.outputs(), &sampling)?;
        let (decoded, decoder) = self.decoder.forward(self.from_latent.forward(&tokens), sampling.positions());
        let sequence = self.output.forward(&decoded);
        let pass = AutoencoderPass { batch, x, hidden, encoder, control_tokens, tokens, sampling, decoder, decoded };
        Ok((Output { control_points, sequence }, pass))
    }

    /// Returns how many sequences there are.
    fn check(&self, numbers: usize, tokens: usize) -> Result<usize, PassError> {
        let unit = tokens * self.inputs;
        if unit == 0 || numbers == 0 || !numbers.is_multiple_of(unit) {
            return Err(PassError::Size { what: "sequences", unit, got: numbers });
        }
        Ok(numbers / unit)
    }

    fn encoded(&self, x: &[f32], tokens: usize) -> Encoded {
        let (points, c) = (self.points(), self.width());
        let hidden = self.input[0].forward(x);
        let embedded = self.input[1].forward(&activated(&hidden));
        let sequences = embedded.chunks_exact(tokens * c);
        let mut all = Vec::with_capacity(embedded.len() + sequences.len() * points * c);
        for sequence in sequences {
            all.extend_from_slice(&self.control.0);
            all.extend_from_slice(sequence);
        }
        let (encoded, encoder) = self.encoder.forward(all, &positions(points, tokens));
        let heads_of_rows = encoded.chunks_exact((points + tokens) * c).flat_map(|rows| &rows[..points * c]);
        let control_tokens: Vec<f32> = heads_of_rows.copied().collect();
        let control_points = self.to_latent.forward(&control_tokens);
        Encoded { hidden, encoder, control_tokens, control_points }
    }

    /// Returns the gradients of all parameters, in a row like theirs.
    ///
    /// # Shapes
    /// The loss's derivative by each number of [`Output::sequence`], and by each of [`Output::control_points`] where the
    /// loss has a term of them.
    ///
    /// # Errors
    /// Gradients of another size than the outputs.
    pub fn backward(
        &self,
        pass: AutoencoderPass,
        by_sequence: &[f32],
        by_control_points: Option<&[f32]>,
    ) -> Result<Vec<f32>, PassError> {
        let AutoencoderPass { batch, x, hidden, encoder, control_tokens, tokens, sampling, decoder, decoded } = pass;
        let (points, c, d, steps) = (self.points(), self.width(), self.to_latent.outputs(), sampling.len());
        let latents = batch * points * d;
        let sizes = [
            ("gradients by the sequence", by_sequence.len(), x.len()),
            ("gradients by the control points", by_control_points.map_or(latents, <[f32]>::len), latents),
        ];
        if let Some((what, got, unit)) = sizes.into_iter().find(|(_, got, expected)| got != expected) {
            return Err(PassError::Size { what, unit, got });
        }
        let mut sums = vec![0.0; self.count];

        let gradient = self.output.backward(&decoded, by_sequence, &mut sums);
        let gradient = self.decoder.backward(decoder, gradient, &mut sums);
        let gradient = self.from_latent.backward(&tokens, &gradient, &mut sums);
        let mut gradient = self.tokens.by_control_points(&gradient, d, &sampling)?;
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
            add(&mut sums[self.control.1.clone()], &rows[..points * c]);
            by_embedded.extend_from_slice(&rows[points * c..]);
        }
        let mut gradient = self.input[1].by_input(&by_embedded);
        let hidden = stack::through_gelu(&hidden, &mut gradient);
        self.input[1].learn(&hidden, &by_embedded, &mut sums);
        self.input[0].learn(&x, &gradient, &mut sums);
        Ok(sums)
    }

    /// c.
    fn width(&self) -> usize {
        self.input[1].outputs()
    }

    /// P.
    fn points(&self) -> usize {
        self.control.0.len() / self.width().max(1)
    }
}

/// The encoder's half of a forward pass.
struct Encoded {
    hidden: Vec<f32>,
    encoder: StackPass,
    control_tokens: Vec<f32>,
    control_points: Vec<f32>,
}
