//! Networks written out by hand on rows of numbers, for a CPU: what their parts share.
//!
//! All parameters stand in one row of numbers by name ([`Layout`]), where Adam and averages are plain loops. A part packs its
//! weights once ([`PackedWeight`]), goes forward and keeps what the way back needs, and adds its parameters' gradients to a row
//! like the parameters'. One pass is one thread's work; who has several cores splits a batch into parts and adds gradients in
//! the parts' order, and so gets the same numbers on any number of threads.

pub(crate) mod elementary;
pub(crate) mod gelu;
pub(crate) mod layer_norm;
mod layout;
mod linear;
pub(crate) mod tile;

pub use gelu::activated;
pub use layout::{Entry, Init, Layout};
pub use linear::{Linear, PackedWeight, add, bias_gradient, weight_gradient};
