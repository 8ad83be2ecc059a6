//! The motion prior (thesis 4.2.1): a latent code for the second of motion around every frame.
//!
//! The main path: clips' frames ([`PriorClip`]) → [`Windows`] (eq. 4.2, normalised by [`FeatureStatistics`]) → a
//! trainer → [`MotionPrior`]. A [`MotionPrior`] is one file that encodes any clip of the same character into one z_t
//! per frame. Trainers are [`vae::VaeTrainer`], [`pca::PcaTrainer`], and a
//! [`crate::spline_transformer::SequenceTrainer`] on [`spline::WindowSequences`].
//!
//! A kind of prior is a folder ([`vae`], [`spline`], [`pca`]) with an implementation of [`PriorKind`] and a line in
//! `kinds.rs`. All users of a [`MotionPrior`] support every kind.

mod dataset;
mod kind;
mod kinds;
mod loss;
mod motion_prior;
pub mod pca;
mod reconstruction;
pub mod spline;
mod statistics;
mod training_plan;
pub mod vae;
mod window_plan;

pub use dataset::{PriorClip, Windows, split};
pub use kind::{KindPlan, PriorData, PriorKind, PriorTraining, WithTrainer};
pub use kinds::PriorPlan;
pub use motion_prior::MotionPrior;
pub use reconstruction::{ReconstructionErrors, ReconstructionReport};
pub use statistics::{FeatureStatistics, StdFloors};
pub use training_plan::PriorTrainingPlan;
pub use window_plan::WindowPlan;
