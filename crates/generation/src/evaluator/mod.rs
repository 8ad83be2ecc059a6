//! The evaluator: encoders of sentences and motions whose embeddings are near where they belong together (in the manner
//! of Guo et al. 2022). [`crate::metrics`] are taken on its embeddings, for whatever method.
//!
//! The main path: [`crate::data::CaptionedMotion`]s → [`EvaluatorTrainer`] (a `TrainingTask`) → [`Evaluator`], one file. Guo et al.
//! pre-train a convolutional snippet encoder for a GRU and push pairs apart by a margin; here strided and residual
//! convolutions see the whole motion, and every pair of a batch is told from all others at once (`contrastive.rs`),
//! which needs minutes on two cores.

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
pub use train::{EvaluatorMetrics, EvaluatorTrainer};
