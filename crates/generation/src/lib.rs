//! Floor 6: text to motion that a robot can execute (thesis chapter 5, RobotMDM).
//!
//! - [`text`]: prompts as numbers (built-in word pieces, frozen MiniLM), and how well a prompt is read.

mod error;
pub mod text;

pub use error::GenerationError;
