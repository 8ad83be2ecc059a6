//! Floor 6: text to motion that a robot can execute (thesis chapter 5, RobotMDM).
//!
//! - [`critic`] (5.2.1): the reward that a tracking policy will get for a motion, differentiable by the motion.
//! - [`representation`] (5.2): a clip as rows of 7 + 2j numbers at 20 Hz, and back; [`space`]: rows or spline control
//!   points as the tokens of a network.
//! - [`diffusion`] and [`denoiser`] (5.2.2): from noise to motion; [`training`] learns it from captioned motion, and
//!   [`generator`] is the trained result: sentences to motions of a robot.
//! - [`data`]: motion with its sentences, of one robot.
//! - [`align`] (5.2.2): fine-tuning of a generator toward a higher value of the critic.
//! - [`evaluator`]: contrastive encoders of sentences and motions, whose embeddings the metrics use.
//! - [`metrics`]: R-precision, FID and the others of Guo et al., with intervals.
//! - [`text`]: prompts as numbers (built-in word pieces), and how well a prompt is read.

pub mod align;
pub mod critic;
pub mod data;
pub mod denoiser;
pub mod diffusion;
mod error;
pub mod evaluator;
pub mod generator;
pub mod metrics;
pub mod representation;
pub mod space;
pub mod text;
pub mod training;

pub use error::GenerationError;
use lifelike_checkpoint::FromInput;

/// The README's example is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
