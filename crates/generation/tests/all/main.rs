//! Tests of generation at its public interface: one program, so that it is linked once.

mod align;
mod bert;
mod denoiser;
mod diffusion;
mod evaluator;
mod metrics;
mod representation;
mod space;
mod training;
