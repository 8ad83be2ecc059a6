//! Sizes of a [`super::SplineAutoencoder`].

use serde::{Deserialize, Serialize};

use super::latent::LatentTokens;
use crate::spline::CubicBezier;

/// Sizes, by the letters of thesis Table A.1 where it has one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AutoencoderConfig {
    /// Numbers of one element of the sequence.
    pub inputs: usize,
    /// d: numbers of one latent control point.
    pub latent: usize,
    /// n: blocks of the encoder, and as many of the decoder.
    pub layers: usize,
    /// h: heads of each block.
    pub heads: usize,
    /// c: numbers of one token.
    pub width: usize,
    /// FFN: inner width of the feed-forward part by `width`.
    pub factor: usize,
    /// Kind of the decoder's tokens.
    pub tokens: LatentTokens,
}

/// Sizes that do not make a network.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NetworkError {
    /// A size is zero.
    #[error("transformer: {0} is 0, expected at least 1")]
    Zero(&'static str),
    /// The heads do not share the width evenly.
    #[error("transformer: {heads} heads do not divide a width of {width}")]
    Heads {
        /// h.
        heads: usize,
        /// c.
        width: usize,
    },
}

impl AutoencoderConfig {
    /// Factor 1 and one cubic Bézier segment, as in the thesis.
    pub fn new(inputs: usize, latent: usize, layers: usize, heads: usize, width: usize) -> Self {
        Self { inputs, latent, layers, heads, width, factor: 1, tokens: LatentTokens::Spline(CubicBezier) }
    }

    /// Sets other latent tokens, and nothing else.
    pub fn with_tokens(mut self, tokens: LatentTokens) -> Self {
        self.tokens = tokens;
        self
    }

    /// Checks the sizes.
    ///
    /// # Errors
    /// A size is zero, or the heads do not divide the width.
    pub fn check(&self) -> Result<(), NetworkError> {
        let sizes = [
            (self.inputs, "inputs"),
            (self.latent, "latent"),
            (self.layers, "layers"),
            (self.heads, "heads"),
            (self.width, "width"),
            (self.factor, "factor"),
        ];
        if let Some((_, name)) = sizes.into_iter().find(|(size, _)| *size == 0) {
            return Err(NetworkError::Zero(name));
        }
        if !self.width.is_multiple_of(self.heads) {
            return Err(NetworkError::Heads { heads: self.heads, width: self.width });
        }
        Ok(())
    }
}
