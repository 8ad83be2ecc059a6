//! A trained network's passes, outside of training: numbers in, numbers out.

use burn::tensor::{Tensor, TensorData};
use lifelike_nn::device;
use lifelike_nn::numbers::read;
use lifelike_nn::transformer::backprop::PassError;
use lifelike_nn::transformer::{Sampling, SplineAutoencoder};
use rayon::prelude::*;

use crate::RepresentationError;

/// Sequences per pass: attention holds all pairs of tokens of all of them.
const CHUNK: usize = 32;

/// Returns control points of sequences. A core for each part of them: the products within a part are too small to share.
///
/// # Shapes
/// `[N, tokens, width]`, in the network's numbers, to `[N, control points, d]`.
pub(crate) fn control_points(
    network: &SplineAutoencoder,
    rows: &[f32],
    [tokens, width]: [usize; 2],
) -> Result<Vec<f32>, RepresentationError> {
    let parts: Vec<_> = rows.chunks(CHUNK * tokens * width).map(|part| (network.clone(), part)).collect();
    let points = parts.into_par_iter().map(|(network, part)| {
        let shape = [part.len() / (tokens * width), tokens, width];
        let x = Tensor::<3>::from_data(TensorData::new(part.to_vec(), shape), &device::inference());
        read(network.encode(x))
    });
    Ok(points.collect::<Result<Vec<_>, _>>()?.concat())
}

/// Sequences of control points of `latent` numbers each.
///
/// # Shapes
/// `[N, control points, latent]` to `[N, sampling, width]`.
pub(crate) fn sequences(
    network: &SplineAutoencoder,
    points: &[f32],
    latent: usize,
    sampling: &Sampling,
) -> Result<Vec<f32>, RepresentationError> {
    let count = network.tokens().control_points();
    let mut out = Vec::new();
    for part in points.chunks(CHUNK * count * latent) {
        let shape = [part.len() / (count * latent), count, latent];
        let part = Tensor::<3>::from_data(TensorData::new(part.to_vec(), shape), &device::inference());
        out.extend(read(network.decode(part, sampling).map_err(PassError::from)?)?);
    }
    Ok(out)
}
