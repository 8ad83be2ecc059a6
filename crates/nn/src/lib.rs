//! Network blocks, losses, schedules and optimizers for learned motion (floor 3).
//!
//! Of our crates it imports only `checkpoint`, `dense` and `simd`. A network lists its parameters
//! ([`parameters::ParameterList`], [`rows::Layout`]) and packs them into blocks: [`mlp`], [`conv_resnet`], [`transformer`],
//! [`fusion`]. A forward pass, a loss ([`losses`]) and a backward pass fill a row of gradients. [`adam::Adam::step`] takes the
//! step, with a learning rate from [`schedules`]. Names, not positions, tie parameters, moments and files together.

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
