//! Principal components of windows: the best linear encoder and decoder of a size (Eckart and Young 1936), and so the row that any
//! learned prior has to beat, on the same windows and with the same number of numbers.
//!
//! It is a prior like any other: policies can be given its codes, too. A β-VAE can have it as a linear path
//! ([`super::vae::VaePlan::linear_path`]).

mod coder;
mod fit;
mod plan;
mod train;

pub use coder::Components;
pub(super) use fit::{Normalized, Subspace};
pub use plan::PcaPlan;
pub use train::{PcaMetrics, PcaTrainer};
