//! The transformer encoder of Vaswani et al. 2017 as PyTorch has it (`TransformerEncoderLayer`: layer norm after each
//! sum, biases, GELU, no dropout), for sequences of different lengths, forward and backward by hand on a CPU.
//!
//! A batch is the tokens of all its sequences, one after the other, `[sum of lengths, c]`: nothing is padded, so
//! nothing is masked. It is made of [`crate::rows`].
//!
//! `cargo run --release -p lifelike-nn --example encoder` times a step; `peers/encoder/step.py` is PyTorch's.

mod layer;
mod sizes;
mod stack;

pub use sizes::EncoderSizes;
pub use stack::{Encoder, EncoderPass};
