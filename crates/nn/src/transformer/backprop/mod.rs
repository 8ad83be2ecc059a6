//! The gradient of a [`SplineAutoencoder`] by hand, for training on a CPU. Automatic differentiation writes every
//! intermediate result of every operation to memory, in one thread; it stays the way on a card, and tests hold this against
//! it and against PyTorch.
//!
//! Products with weights are those of [`crate::rows`]; attention, normalization and GELU are loops over our own memory.
//! `cargo run --release -p lifelike-nn --example transformer` on two cores, best of 7: 0.77 s instead of 3.0 s a step for 64 curves of
//! 256 tokens of width 64, 0.36 s instead of 0.77 s for 64 motions of 64 tokens of width 128; 0.57 s and 0.24 s where parts of a batch
//! have a core each.

pub(super) mod attention;
mod linear;
mod norm;
mod softmax;
mod stack;
mod threads;

use burn::tensor::{Tensor, TensorData};

use super::autoencoder::{SplineAutoencoder, positions};
use super::sampling::Sampling;
use crate::gradients::Gradients as Grads;
use crate::numbers::{Unreadable, read};
use crate::spline::SplineError;
use linear::{affine, by_input, learn_affine, numbers, put, through_affine};
use stack::StackPass;

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

/// Numbers of the forward pass that the backward one needs: about 7 numbers for each token, width and block.
#[derive(Debug, Clone)]
pub struct AutoencoderPass {
    sampling: Sampling,
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

/// As [`SplineAutoencoder::forward`], outside of automatic differentiation.
///
/// # Shapes
/// `x: [B, T, inputs]`, row-major, with T = `tokens`.
///
/// # Errors
/// `x` does not hold whole sequences, or tensor data that cannot be read from the device.
pub fn forward(
    network: &SplineAutoencoder,
    x: Vec<f32>,
    tokens: usize,
) -> Result<(Output, AutoencoderPass), PassError> {
    let inputs = network.input.hidden.weight.dims()[0];
    let ([points, c], d) = (network.control.dims(), network.to_latent.bias.dims()[0]);
    let unit = tokens * inputs;
    if unit == 0 || x.is_empty() || !x.len().is_multiple_of(unit) {
        return Err(PassError::Size { what: "sequences", unit, got: x.len() });
    }
    let batch = x.len() / unit;

    let hidden = affine(&x, &network.input.hidden)?;
    let embedded = affine(&stack::activated(&hidden), &network.input.output)?;
    let control = numbers(&network.control)?;
    let mut all = Vec::with_capacity(batch * (points + tokens) * c);
    for sequence in embedded.chunks_exact(tokens * c) {
        all.extend_from_slice(&control);
        all.extend_from_slice(sequence);
    }
    let (encoded, encoder) = stack::forward(&network.encoder, all, &positions(points, tokens), network.heads)?;
    let heads_of_rows = encoded.chunks_exact((points + tokens) * c).flat_map(|rows| &rows[..points * c]);
    let control_tokens: Vec<f32> = heads_of_rows.copied().collect();
    let control_points = affine(&control_tokens, &network.to_latent)?;

    // The latent step is small, and the one that differs between methods: automatic differentiation does it.
    let device = network.control.val().device().inner().autodiff();
    let sampling = Sampling::each(tokens);
    let latent = Tensor::<3>::from_data(TensorData::new(control_points.clone(), [batch, points, d]), &device);
    let latent = latent.require_grad();
    let latent_tokens = network.tokens.tokens(latent.clone(), &sampling)?;
    let decoder_in = affine(&read(latent_tokens.clone().inner())?, &network.from_latent)?;
    let (decoded, decoder) = stack::forward(&network.decoder, decoder_in, sampling.positions(), network.heads)?;
    let sequence = affine(&decoded, &network.output)?;
    let tokens = latent_tokens;
    let pass =
        AutoencoderPass { sampling, batch, x, hidden, encoder, control_tokens, latent, tokens, decoder, decoded };
    Ok((Output { control_points, sequence }, pass))
}

/// Gradients of all parameters, by their names in the network.
///
/// # Shapes
/// The loss's derivative by each number of [`Output::sequence`], and by each of [`Output::control_points`] where the loss
/// has a term of them.
///
/// # Errors
/// Gradients of another size than the outputs, or tensor data that cannot be read from the device.
pub fn backward(
    network: &SplineAutoencoder,
    pass: AutoencoderPass,
    by_sequence: Vec<f32>,
    by_control_points: Option<Vec<f32>>,
) -> Result<Grads, PassError> {
    let AutoencoderPass { sampling, batch, x, hidden, encoder, control_tokens, latent, tokens, decoder, decoded } =
        pass;
    let ([points, c], steps) = (network.control.dims(), sampling.len());
    let sizes = [
        ("gradients by the sequence", by_sequence.len(), x.len()),
        (
            "gradients by the control points",
            by_control_points.as_ref().map_or(latent.shape().num_elements(), Vec::len),
            latent.shape().num_elements(),
        ),
    ];
    if let Some((what, got, unit)) = sizes.into_iter().find(|(_, got, expected)| got != expected) {
        return Err(PassError::Size { what, unit, got });
    }
    let mut grads = Grads::default();

    let gradient = through_affine(&decoded, &network.output, &by_sequence, "output", &mut grads)?;
    let gradient = stack::backward(&network.decoder, decoder, gradient, "decoder", &mut grads)?;
    let latent_tokens = read(tokens.clone().inner())?;
    let gradient = through_affine(&latent_tokens, &network.from_latent, &gradient, "from_latent", &mut grads)?;
    let gradient = Tensor::<3>::from_data(TensorData::new(gradient, tokens.dims()), &tokens.device());
    let mut tape = (tokens * gradient).sum().backward();
    let mut gradient = match latent.grad_remove(&mut tape) {
        Some(gradient) => read(gradient)?,
        None => vec![0.0; latent.shape().num_elements()],
    };
    if let Some(more) = by_control_points {
        gradient.iter_mut().zip(&more).for_each(|(gradient, more)| *gradient += more);
    }
    let gradient = through_affine(&control_tokens, &network.to_latent, &gradient, "to_latent", &mut grads)?;

    // Only the control tokens' outputs were read.
    let mut by_encoded = vec![0.0; batch * (points + steps) * c];
    let rows = by_encoded.chunks_exact_mut((points + steps) * c);
    rows.zip(gradient.chunks_exact(points * c))
        .for_each(|(rows, gradient)| rows[..points * c].copy_from_slice(gradient));
    let gradient = stack::backward(&network.encoder, encoder, by_encoded, "encoder", &mut grads)?;
    let mut by_control = vec![0.0; points * c];
    let mut by_embedded = Vec::with_capacity(batch * steps * c);
    for rows in gradient.chunks_exact((points + steps) * c) {
        by_control.iter_mut().zip(rows).for_each(|(sum, gradient)| *sum += gradient);
        by_embedded.extend_from_slice(&rows[points * c..]);
    }
    put(&network.control, by_control, "control".to_owned(), &mut grads);
    let input = &network.input;
    let mut gradient = by_input(&input.output.weight, &by_embedded)?;
    let activated = stack::through_gelu(&hidden, &mut gradient);
    learn_affine(&activated, &input.output, &by_embedded, "input.output", &mut grads);
    learn_affine(&x, &input.hidden, &gradient, "input.hidden", &mut grads);
    Ok(grads)
}
