//! Named arrays and metadata in one verified file, and addressed random streams: state that continues bit for bit (floor 0).
//!
//! [`Checkpoint`] is named arrays and JSON metadata in one safetensors file with a digest. [`rng::stream`] is
//! randomness by address, so that a resumed run draws the same numbers as an uninterrupted one. [`write_file`] replaces
//! a file atomically.
//!
//! Imports none of our other crates, and no training framework: robots load such files too.

mod checkpoint;
mod input;
pub mod rng;
mod whole_file;

pub use checkpoint::{Checkpoint, CheckpointError, Entry, Kind};
pub use input::{FromInput, InputError};
pub use whole_file::{PARTIAL, write_file};

/// The README's examples, run as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
