//! The critic v(m) of a tracking policy (thesis 5.2.1): the discounted reward that a window of motion promises, by the
//! motion alone and differentiable by it. Several networks are one critic, whose value is their least.
//!
//! The main path: [`RewardRecords`] of a frozen controller and its clips' rows → [`CriticData`] → [`CriticTrainer`] (a
//! [`lifelike_train::TrainingTask`]) → [`Critic`] (`*.critic.safetensors`), a [`RewardSurrogate`]. Everything
//! else of this crate knows the tracker by that trait alone.

pub mod calibration;
mod data;
mod ensemble;
mod file;
mod member;
mod network;
mod plan;
mod surrogate;
mod task;
#[cfg(test)]
mod tests;
mod trainer;
mod windows;

pub use data::{CriticData, OtherRows};
pub use file::{Critic, CriticHeader, EXTENSION};
pub use lifelike_train::{RewardRecords, StepEnd};
pub use network::Bounds;
pub use plan::CriticPlan;
pub use surrogate::RewardSurrogate;
pub use trainer::{CriticMetrics, CriticTrainer};
