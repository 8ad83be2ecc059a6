//! Tests of generation at its public interface: one program, so that it is linked once.

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod align;
mod denoiser;
mod diffusion;
mod evaluator;
mod metrics;
mod representation;
mod space;
mod training;
