//! Floor 6: text to motion that a robot can execute (thesis chapter 5, RobotMDM).
//!
//! - [`representation`] (5.2): a clip as rows of 7 + 2j numbers at 20 Hz, and back.
//! - [`evaluator`]: contrastive encoders of sentences and motions, on whose embeddings the metrics are taken.
//! - [`metrics`]: R-precision, FID and the others of Guo et al., with intervals.
//! - [`text`]: prompts as numbers (built-in word pieces, frozen MiniLM), and how well a prompt is read.

mod error;
pub mod evaluator;
pub mod metrics;
pub mod representation;
pub mod text;

pub use error::GenerationError;
