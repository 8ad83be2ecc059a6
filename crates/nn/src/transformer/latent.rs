//! The sequence between encoder and decoder (thesis Fig. 3.2): the one thing in which method and baselines differ.

use serde::{Deserialize, Serialize};

use super::sampling::Sampling;
use crate::spline::{CubicBezier, SplineError};

/// Way to make the decoder's tokens of what the encoder left in its control tokens.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LatentTokens {
    /// Control points of a curve, which is sampled. No token knows where it stands but by where the curve is.
    Spline(CubicBezier),
    /// One latent vector for all tokens, sinusoids of the position added.
    Alibi,
    /// One latent vector for all tokens, sinusoids of the position beside it: tokens twice as wide, which a linear map brings to c.
    AlibiCat,
    /// As [`Self::AlibiCat`] with a decoder of blocks of width 2 c (thesis 3.3: "doubling the size of the transformer decoder blocks").
    AlibiCatWide,
}

impl LatentTokens {
    /// Returns the number of control tokens that the encoder reads out.
    pub fn control_points(&self) -> usize {
        match self {
            Self::Spline(_) => CubicBezier::CONTROL_POINTS,
            Self::Alibi | Self::AlibiCat | Self::AlibiCatWide => 1,
        }
    }

    /// Returns the width of the decoder's tokens for control points of `latent` numbers.
    pub fn width(&self, latent: usize) -> usize {
        match self {
            Self::Spline(_) | Self::Alibi => latent,
            Self::AlibiCat | Self::AlibiCatWide => 2 * latent,
        }
    }

    /// Returns the width of the decoder's blocks, for an encoder of `width`.
    pub fn decoder_width(&self, width: usize) -> usize {
        match self {
            Self::Spline(_) | Self::Alibi | Self::AlibiCat => width,
            Self::AlibiCatWide => 2 * width,
        }
    }

    /// Returns the decoder's tokens.
    ///
    /// # Shapes
    /// `[B, control points, d]` to `[B, sampling, width]`.
    ///
    /// # Errors
    /// Numbers that are not whole sequences of control points.
    pub fn tokens(&self, control_points: &[f32], d: usize, sampling: &Sampling) -> Result<Vec<f32>, SplineError> {
        let expected = self.control_points();
        if d == 0 || !control_points.len().is_multiple_of(expected * d) {
            return Err(SplineError::WrongControlPoints { expected, got: control_points.len() / d.max(1) });
        }
        if let Self::Spline(spline) = self {
            return spline.evaluate(control_points, d, &sampling.parameters());
        }
        let waves = sinusoids(sampling.positions(), d);
        let mut out = Vec::with_capacity(control_points.len() / d * waves.len() * 2);
        for point in control_points.chunks_exact(d) {
            for wave in waves.chunks_exact(d) {
                match self {
                    Self::Alibi => out.extend(point.iter().zip(wave).map(|(x, wave)| wave + x)),
                    _ => out.extend(point.iter().chain(wave)),
                }
            }
        }
        Ok(out)
    }

    /// Returns the gradient by the control points, from that by the tokens.
    ///
    /// # Shapes
    /// `[B, sampling, width]` to `[B, control points, d]`.
    ///
    /// # Errors
    /// As [`Self::tokens`].
    pub fn by_control_points(&self, gradient: &[f32], d: usize, sampling: &Sampling) -> Result<Vec<f32>, SplineError> {
        if let Self::Spline(spline) = self {
            return spline.by_control_points(gradient, d, &sampling.parameters());
        }
        let width = self.width(d);
        let mut out = Vec::with_capacity(gradient.len() / (sampling.len() * width).max(1) * d);
        for tokens in gradient.chunks((sampling.len() * width).max(1)) {
            let mut sum = vec![0.0; d];
            for token in tokens.chunks_exact(width) {
                sum.iter_mut().zip(token).for_each(|(sum, x)| *sum += x);
            }
            out.extend(sum);
        }
        Ok(out)
    }
}

/// Vaswani et al. 2017, 3.5: number 2i of a token is sin(position / 10000^(2i/d)), number 2i + 1 its cosine.
///
/// # Shapes
/// `[positions, d]`.
fn sinusoids(positions: &[f64], d: usize) -> Vec<f32> {
    let mut values = Vec::with_capacity(positions.len() * d);
    for position in positions {
        for i in 0..d {
            let angle = position / 10000_f64.powf((i - i % 2) as f64 / d as f64);
            values.push(if i % 2 == 0 { angle.sin() } else { angle.cos() } as f32);
        }
    }
    values
}
