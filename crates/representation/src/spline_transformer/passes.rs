//! A trained network's passes, outside of training: numbers in, numbers out.

use lifelike_nn::transformer::passes::PassError;
use lifelike_nn::transformer::{Sampling, SplineAutoencoder};
use rayon::prelude::*;

use crate::RepresentationError;

/// Sequences per pass: attention holds all pairs of tokens of all of them.
const CHUNK: usize = 32;

/// Returns control points of sequences. A core for each part of them.
///
/// # Shapes
/// `[N, tokens, width]`, in the network's numbers, to `[N, control points, d]`.
pub(crate) fn control_points(
    network: &SplineAutoencoder,
    rows: &[f32],
    [tokens, width]: [usize; 2],
) -> Result<Vec<f32>, RepresentationError> {
    let weights = network.weights();
    let points = rows.par_chunks(CHUNK * tokens * width).map(|part| weights.encode(part, tokens));
    Ok(points.collect::<Result<Vec<_>, PassError>>()?.concat())
}

/// Sequences of control points of `latent` numbers each.
///
/// # Shapes
/// `[N, control points, latent]` to `[N, sampling, width]`.
pub(crate) fn sequences(
    network: &SplineAutoencoder,
    points: &[f32],
    sampling: &Sampling,
) -> Result<Vec<f32>, RepresentationError> {
    let (weights, config) = (network.weights(), network.config());
    let unit = config.tokens.control_points() * config.latent;
    let parts = points.par_chunks(CHUNK * unit).map(|part| weights.decode(part, sampling));
    Ok(parts.collect::<Result<Vec<_>, PassError>>()?.concat())
}
