//! Floor 4: learning. `representation` (the motion prior) ← `tracking` (PPO) with `evaluation` beside them.

pub mod error;
pub mod evaluation;
mod limits;
pub mod report;
pub mod representation;
pub mod run;
pub mod tracking;

pub use error::LearnError;
