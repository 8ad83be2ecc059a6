//! Tests of nn at its public interface: one program, so that it is linked once.

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod contract_checkpoint;
mod encoder;
mod fixture;
mod fusion;
mod pytorch;
mod spline;
mod transformer;
mod transformer_sizes;
