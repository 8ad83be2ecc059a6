//! Training of the Spline-based Transformer and its baselines (thesis chapter 3).
//!
//! The main path: something that has [`Sequences`] (windows of [`Recording`]s here; curves, images, strands and
//! captured people in
//! `lifelike-sequences`) and a [`SequencePlan`] → [`SequenceTrainer`], a [`lifelike_train::TrainingTask`]. The three
//! [`Method`]s differ in how the decoder's tokens are made and in nothing else: same seed, same batches.

pub(super) mod passes;
mod plain;
mod plan;
mod recordings;
pub mod run;
mod sequences;
mod spread;
mod task;
mod train;

pub use plain::Plain;
pub use plan::{Method, SequencePlan};
pub use recordings::{Recording, RecordingWindows, Split};
pub use sequences::{HeldOut, Sequences};
pub use spread::Spread;
pub use train::{SequenceErrors, SequenceTrainer};
