//! MDM's denoiser (Tevet et al. 2023): a transformer encoder over the prompt's tokens, one token of the diffusion step, and
//! the noisy motion's tokens; what comes out at the motion's places is the clean motion (thesis eq. 5.6).
//!
//! Where MDM has one token for the sentence, this has one for each of its tokens. Parameters are one row of numbers; the
//! gradient is by hand, on a CPU.

mod network;
mod position;
mod sizes;

pub use network::{Denoiser, DenoiserInput, DenoiserPass};
pub use sizes::{DenoiserSizes, TextInput};
