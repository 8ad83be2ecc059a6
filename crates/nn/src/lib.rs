//! Floor 3, beside the simulation: network blocks, losses, schedules, checkpoints and addressed randomness.
//!
//! Imports none of our other crates.

pub mod rng;
