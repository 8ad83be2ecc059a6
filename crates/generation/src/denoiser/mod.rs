//! MDM's denoiser (Tevet et al. 2023): a transformer encoder over the tokens of prompt, diffusion step and noisy
//! motion.
//!
//! The outputs at the motion's positions are the clean motion (thesis eq. 5.6). MDM has one token for the sentence;
//! this one has one for each of its tokens. Parameters are one row of numbers; the gradient is written by hand, on a
//! CPU.

mod network;
mod position;
mod sizes;

pub use network::{Denoiser, DenoiserInput, DenoiserPass};
pub use sizes::{DenoiserSizes, TextInput};
