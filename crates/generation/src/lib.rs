//! Floor 6: text to motion that a robot can execute (thesis chapter 5, RobotMDM).
//!
//! - [`text`]: prompts as numbers (built-in word pieces, frozen MiniLM), and how well a prompt is read.
//! - [`critic`] (5.2.1): the reward that a tracking policy will get for a motion, differentiable by the motion.
//! - [`representation`] (5.2): a clip as rows of 7 + 2j numbers at 20 Hz, and back.

pub mod critic;
mod error;
pub mod representation;
pub mod text;

pub use error::GenerationError;
