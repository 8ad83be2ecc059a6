//! The convolutional β-VAE of thesis 4.2.1 as a motion prior.
//!
//! The main path: a [`VaePlan`] and clips → [`VaeTrainer`], which trains a [`MotionVae`] on eqs. 4.3-4.4 →
//! [`VaeTrainer::prior`].

mod coder;
mod file;
pub mod network;
mod plan;
mod task;
mod train;

pub use network::MotionVae;
pub use plan::VaePlan;
pub use train::{VaeMetrics, VaeTrainer};
