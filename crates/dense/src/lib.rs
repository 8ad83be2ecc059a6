//! Floor 0: dense kernels in single precision, row-major, for networks that run without a training framework.
//!
//! [`product`] calls the kernel that the training framework's CPU backend calls, in the same way, and [`elu`] is the one
//! that training uses: a frozen perceptron gives the trained one's numbers bit for bit.

mod elu;
mod layer_norm;
mod product;

pub use elu::elu;
pub use layer_norm::layer_norm;
pub use product::{product, product_by_row};

/// The README's example is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
