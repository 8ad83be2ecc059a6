//! Transformers over sequences of fixed length, and the Spline-based Transformer (thesis chapter 3, appendix A).
//!
//! [`SplineAutoencoder`] is a network's sizes and parameters; [`LatentTokens`] are the one thing in which the method and its
//! baselines differ. [`passes`] runs it forward and backward. [`encoder`] is the encoder of Vaswani et al. for sequences of different
//! lengths. Images become sequences by [`patches`].

pub mod alibi;
mod autoencoder;
mod config;
pub mod encoder;
mod latent;
pub mod passes;
pub mod patches;
mod sampling;

pub use autoencoder::SplineAutoencoder;
pub use config::{AutoencoderConfig, NetworkError};
pub use latent::LatentTokens;
pub use sampling::Sampling;
