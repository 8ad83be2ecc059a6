//! Floor 1: dense kernels in single precision, for networks that learn on this machine and for frozen ones.
//!
//! Every sum has one order, with multiply-adds that are rounded once. It does not depend on the instruction set
//! ([`lifelike_simd::InstructionSet`]), the number of rows or the number of threads. A frozen [`Perceptron`] equals the
//! trained [`PackedPerceptron`] bit for bit.

mod adam;
mod elu;
mod gru;
mod layer;
mod layer_norm;
mod packed;
mod panel;
mod perceptron;
mod product;
mod weight_gradient;

pub use adam::{AdamStep, Slices, norm};
pub use elu::{elu, elu_of_vector};
pub use gru::{Gru, GruMemory, GruSizes, PackedGru};
pub use layer_norm::layer_norm;
pub use packed::PackedPerceptron;
pub use panel::{Channel, ROWS, pack, unpack};
pub use perceptron::{Between, LayerSizes, Perceptron, Sizes};
pub use product::{product, product_on_this_thread};

/// The README's example is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
