//! The evaluator: encoders of sentences and motions with close embeddings for matching pairs (in the manner of Guo et
//! al. 2022). [`crate::metrics`] use its embeddings for every method.
//!
//! The main path: [`crate::data::CaptionedMotion`]s → [`EvaluatorTrainer`] (a `TrainingTask`) → [`Evaluator`], one
//! file. Guo et al. pre-train a convolutional snippet encoder for a GRU and separate pairs by a margin. Here strided
//! and residual convolutions see the whole motion. The loss (`contrastive.rs`) separates every pair of a batch from all
//! others at once, which takes minutes on two cores.

mod contrastive;
mod data;
mod encoder;
mod file;
mod found;
mod network;
mod plan;
mod task;
mod train;

pub use data::{EvaluatorData, caption_kinds};
pub use file::Evaluator;
pub use network::EvaluatorNetwork;
pub use plan::{EvaluatorPlan, EvaluatorTrainingPlan};
pub use train::EvaluatorTrainer;
