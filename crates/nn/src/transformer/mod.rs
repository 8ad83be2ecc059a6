//! Transformers over sequences of fixed length, and the Spline-based Transformer (thesis chapter 3, appendix A).
//!
//! [`SplineAutoencoder`] holds a network's sizes and parameters; [`passes`] runs it forward and backward. The method and its
//! baselines differ in their [`LatentTokens`] only. [`encoder`] is the encoder of Vaswani et al. for sequences of different
//! lengths. [`patches`] turns images into sequences.

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
