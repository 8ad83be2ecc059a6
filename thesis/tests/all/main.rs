//! Tests of the thesis’ tables at its public interface: one program, so that it is linked once.

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod autoencoders;
mod critic;
mod curve_sequences;
mod curves;
mod generation;
mod latent;
mod programs;
mod tracking;
