//! The transformer encoder of Vaswani et al. 2017 as PyTorch has it (`TransformerEncoderLayer`: layer norm after each sum,
//! biases, GELU, no dropout), for sequences of different lengths, forward and backward by hand on a CPU.
//!
//! A batch is the tokens of all its sequences, one after the other, `[sum of lengths, c]`: nothing is padded, so nothing
//! is masked. All parameters stand in one row of numbers ([`Layout`]), where Adam and averages are plain loops. One pass
//! is one thread's work; who has several cores splits a batch into parts and adds gradients in the parts' order, and so
//! gets the same numbers on any number of threads.
//!
//! `cargo run --release -p lifelike-nn --example encoder` times a step; `peers/encoder/step.py` is PyTorch's.

mod layer;
mod layer_norm;
mod layout;
mod linear;
mod stack;

pub use layout::{Entry, Init, Layout};
pub use linear::{PackedWeight, add, bias_gradient, weight_gradient};
pub use stack::{Encoder, EncoderPass, EncoderSizes};
