//! The sequence between encoder and decoder (thesis Fig. 3.2): the one thing in which method and baselines differ.

use burn::tensor::{Device, Tensor, TensorData};
use serde::{Deserialize, Serialize};

use super::sampling::Sampling;
use crate::spline::{Spline, SplineError};

/// Way to make the decoder's tokens of what the encoder left in its control tokens.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LatentTokens {
    /// Control points of a curve, which is sampled. No token knows where it stands but by where the curve is.
    Spline(Spline),
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
            Self::Spline(spline) => spline.control_points(),
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

    /// # Shapes
    /// `[B, control points, d]` to `[B, sampling, width]`.
    ///
    /// # Errors
    /// Another number of control points.
    pub fn tokens(&self, control_points: Tensor<3>, sampling: &Sampling) -> Result<Tensor<3>, SplineError> {
        let [b, got, d] = control_points.dims();
        if got != self.control_points() {
            return Err(SplineError::WrongControlPoints { expected: self.control_points(), got });
        }
        let samples = sampling.len();
        let waves = || sinusoids(sampling.positions(), d, &control_points.device()).unsqueeze::<3>();
        match self {
            Self::Spline(spline) => spline.evaluate_at(control_points, &sampling.parameters(), 0),
            Self::Alibi => Ok(waves() + control_points.expand([b, samples, d])),
            Self::AlibiCat | Self::AlibiCatWide => Ok(Tensor::cat(
                vec![control_points.clone().expand([b, samples, d]), waves().expand([b, samples, d])],
                2,
            )),
        }
    }
}

/// Vaswani et al. 2017, 3.5: number 2i of a token is sin(position / 10000^(2i/d)), number 2i + 1 its cosine.
fn sinusoids(positions: &[f64], d: usize, device: &Device) -> Tensor<2> {
    let mut values = Vec::with_capacity(positions.len() * d);
    for position in positions {
        for i in 0..d {
            let angle = position / 10000_f64.powf((i - i % 2) as f64 / d as f64);
            values.push(if i % 2 == 0 { angle.sin() } else { angle.cos() } as f32);
        }
    }
    Tensor::from_data(TensorData::new(values, [positions.len(), d]), device)
}
