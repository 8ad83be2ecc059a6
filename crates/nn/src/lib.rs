//! Network blocks, losses, schedules and optimizers for learned motion, on the `burn` framework (floor 3; of our crates it imports
//! only `checkpoint`, `dense` and `simd`).
//!
//! The main path: [`mlp::MlpConfig::init`], [`conv_resnet`] or [`transformer::AutoencoderConfig::init`] → a loss
//! ([`losses`]) → [`gradients::Gradients::of`] (or a hand-written one: [`backprop`], [`transformer::backprop`]) →
//! [`adam::Adam::step`] with a learning rate from [`schedules`] → [`lifelike_checkpoint::Checkpoint::save`]. Names, not positions, tie
//! parameters, gradients, moments and files together.

pub mod adam;
pub mod backprop;
mod checkpoint;
pub mod conv_resnet;
pub mod device;
pub mod elu;
pub mod flat;
pub mod fusion;
pub mod gradients;
pub mod init;
pub mod losses;
pub mod memory;
pub mod mlp;
mod muon;
mod names;
pub mod normalizer;
pub mod numbers;
pub mod rows;
pub mod schedules;
pub mod spline;
pub mod transformer;

pub use checkpoint::ModuleCheckpoint;
pub use names::parameters;
