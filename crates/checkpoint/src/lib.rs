//! Floor 0: state that continues bit for bit.
//!
//! [`Checkpoint`] is named arrays and JSON metadata in one safetensors file with a digest inside; [`rng::stream`] is
//! randomness by address, so that a resumed run draws what an uninterrupted one would have drawn.
//!
//! Imports none of our other crates, and no training framework: what a robot loads is such a file, too.

mod checkpoint;
pub mod rng;

pub use checkpoint::{Checkpoint, CheckpointError, Entry, Kind};
