//! Network blocks, losses, schedules and optimizers for learned motion, with forward and backward passes of our own (floor 3; of our
//! crates it imports only `checkpoint`, `dense` and `simd`).
//!
//! The main path: a network lists its parameters ([`parameters::ParameterList`], [`rows::Layout`]) → packs them into blocks
//! ([`mlp`], [`conv_resnet`], [`transformer`], [`fusion`]) → forward, a loss ([`losses`]), backward, which adds to a row of gradients →
//! [`adam::Adam::step`] with a learning rate from [`schedules`] → [`lifelike_checkpoint::Checkpoint::save`]. Names, not positions, tie
//! parameters, moments and files together.

pub mod adam;
pub mod conv_resnet;
pub mod fusion;
pub mod init;
pub mod losses;
pub mod memory;
pub mod mlp;
mod muon;
pub mod normalizer;
pub mod parameters;
pub mod rows;
pub mod schedules;
pub mod spline;
pub mod transformer;
