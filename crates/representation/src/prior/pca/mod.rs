//! Principal components of windows: the best linear encoder and decoder of a size (Eckart and Young 1936). Any learned
//! prior has to beat it, on the same windows and with the same number of numbers.
//!
//! It is a prior like any other: policies can be given its codes, too. A β-VAE can have it as a linear path
//! ([`super::vae::VaePlan::linear_path`]).

mod coder;
mod plan;
mod train;

pub use plan::PcaPlan;
pub(super) use train::Normalized;
pub use train::{PcaMetrics, PcaTrainer};
