//! Floor 6: policies.
//!
//! A policy that tracks any motion (thesis chapter 4, second stage), trained by PPO in physics.
//!
//! The main path: [`TrackerPlan`] → [`lifelike_robot::ReferenceLibrary`] (all motion at the policy's rate) → [`Environment`]
//! (many simulated robots, each following a reference) → [`Trainer`] (PPO in them, a [`lifelike_train::TrainingTask`]) →
//! [`Policy`] (the file of which a [`lifelike_robot::Controller`] is made).
//!
//! Declared once, each in the list of one file: reward terms in [`rewards::terms`], rules by which an episode fails in
//! [`terminations`]. [`plan::keys`] lists every key of a plan with unit, default and meaning. Episodes begin where
//! [`reference::rsi`] draws them.

pub mod environment;
mod error;
mod observe;
pub mod plan;
pub mod policy;
pub mod progress;
pub mod reference;
pub mod rewards;
pub mod terminations;
#[cfg(test)]
mod tests;
pub mod trainer;

pub use environment::{Environment, Episode, Start};
pub use error::TrackerError;
pub use lifelike_train::StepOutcome;
pub use plan::TrackerPlan;
pub use policy::Policy;
pub use progress::{ClipProgress, TrackerMetrics};
pub use trainer::Trainer;

/// The example of the README, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
