//! Denoising diffusion of rows of numbers whose clean form a network predicts (thesis eq. 5.6).
//!
//! [`Schedule`] (Nichol & Dhariwal 2021) → [`Sampler`] (Ho et al. 2020 and Song et al. 2021 in one formula), with
//! classifier-free guidance ([`guide`], Ho & Salimans 2022) and numbers that are [`Known`] beforehand.
//! Noise is the caller's, addressed by candidate and step.

mod known;
mod sampler;
mod schedule;

pub use known::Known;
pub use sampler::{Sampler, guide};
pub use schedule::Schedule;
