//! Floor 6: policies.
//!
//! A policy that tracks any motion (thesis chapter 4, second stage), trained by PPO in physics.
//!
//! The main path: [`TrackerPlan`] → [`lifelike_robot::ReferenceLibrary`] (all motion at the policy's rate) →
//! [`Environment`] → [`Trainer`] → [`Policy`]. An [`Environment`] has many simulated robots, each following a
//! reference. The [`Trainer`] runs PPO in it, as a [`lifelike_train::TrainingTask`]. A [`Policy`] is the file from
//! which a [`lifelike_robot::Controller`] is made.
//!
//! [`GetUpSearch`] finds the keyframes of a get-up script instead, by the cross-entropy method.
//!
//! Reward terms are declared in [`rewards::terms`], terminations in [`terminations`], each once. [`lifelike_train::plan::keys`] lists
//! every key of a plan with unit, default and meaning. [`reference::rsi`] draws the starts of episodes.

pub mod environment;
mod episode;
mod error;
pub mod get_up;
mod observe;
pub mod plan;
pub mod policy;
pub mod progress;
pub mod reference;
pub mod rewards;
pub mod terminations;
#[cfg(test)]
mod tests;
mod tracking_error;
pub mod trainer;

pub use environment::{Environment, Start};
pub use episode::Episode;
pub use error::TrackerError;
pub use get_up::{GetUpPlan, GetUpSearch};
use lifelike_checkpoint::FromInput;
pub use lifelike_train::StepOutcome;
pub use plan::TrackerPlan;
pub use policy::Policy;
pub use progress::{ClipProgress, TrackerMetrics};
pub use trainer::Trainer;

/// The example of the README, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
