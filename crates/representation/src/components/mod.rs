//! Principal components: the best linear encoder and decoder of a given size (Eckart and Young 1936).
//!
//! They are the simple baseline of every encoder of windows or sequences.

mod coefficients;
mod subspace;

pub use coefficients::Components;
pub use subspace::{Rows, Subspace};
