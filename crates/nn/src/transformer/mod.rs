//! Transformers over sequences of fixed length, and the Spline-based Transformer (thesis chapter 3, appendix A).
//!
//! From small to large: [`RmsNorm`], [`Attention`] with the [`alibi`] bias, [`FeedForward`] → [`Block`] → [`Stack`] →
//! [`SplineAutoencoder`]. The method and its baselines differ in their [`LatentTokens`] only. [`patches`] turns images
//! into sequences.

pub mod alibi;
mod attention;
mod autoencoder;
pub mod backprop;
mod block;
mod config;
pub mod encoder;
mod feed_forward;
mod heads;
mod latent;
mod norm;
pub mod patches;
mod sampling;

pub use attention::Attention;
pub use autoencoder::SplineAutoencoder;
pub use block::{Block, Stack};
pub use config::{AutoencoderConfig, NetworkError};
pub use feed_forward::FeedForward;
pub use heads::{Affine, InputHead};
pub use latent::LatentTokens;
pub use norm::RmsNorm;
pub use sampling::Sampling;
