//! Floor 6: policies.
//!
//! A policy that tracks any motion (thesis chapter 4, second stage), trained by PPO in physics.
//!
//! The main path: [`TrackerPlan`] → [`lifelike_robot::ReferenceLibrary`] (all motion at the policy's rate) → [`Environment`] (many
//! simulated robots, each following a reference) → [`Trainer`] (PPO in them, a [`lifelike_train::TrainingTask`]) → [`Policy`] (the
//! file that evaluation, the demo and a robot load).

pub mod environment;
mod episode;
mod error;
pub mod errors;
mod ground;
mod judge;
mod observe;
pub mod plan;
pub mod policy;
pub mod progress;
pub mod rewards;
mod senses;
pub mod starts;
pub mod tally;
#[cfg(test)]
mod tests;
pub mod trainer;

pub use environment::Environment;
pub use episode::Episode;
pub use error::TrackerError;
pub use ground::Start;
pub use lifelike_train::StepOutcome;
pub use plan::TrackerPlan;
pub use policy::Policy;
pub use progress::{ClipProgress, TrackerMetrics};
pub use trainer::Trainer;
