//! Shared parts of the networks written by hand on rows of numbers, for a CPU.
//!
//! All parameters are one row of numbers by name ([`Layout`]), on which Adam and averages are plain loops. A part packs
//! its weights once ([`PackedWeight`]) and goes forward, keeping the intermediate results of the backward pass. It adds
//! its parameters' gradients to a row of the same layout. One pass runs in one thread. On several cores split a batch
//! into parts and add gradients in the parts' order: the numbers do not depend on the number of threads.

pub(crate) mod elementary;
pub(crate) mod gelu;
pub(crate) mod layer_norm;
mod layout;
mod linear;
pub(crate) mod tile;

pub(crate) use gelu::activated;
pub use layout::{Entry, Init, Layout};
pub use linear::{Linear, PackedWeight, add, bias_gradient, weight_gradient};
