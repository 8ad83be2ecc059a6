//! Principal components: the best linear encoder and decoder of a size (Eckart and Young 1936), and so the plain baseline of everything
//! that puts windows or sequences into a few numbers.

mod coefficients;
mod subspace;

pub use coefficients::Components;
pub use subspace::{Rows, Subspace};
