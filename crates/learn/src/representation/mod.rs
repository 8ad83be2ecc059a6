//! The motion prior (thesis 4.2.1): a latent code for the second of motion around every frame.
//!
//! The main path: clips' frames → [`dataset::Windows`] (eq. 4.2, normalised by [`statistics::FeatureStatistics`]) →
//! [`vae::MotionVae`] trained by [`train_prior::PriorTrainer`] on eqs. 4.3-4.4 ([`loss`]) → [`prior::MotionPrior`], one file
//! that encodes any clip of the same character into one z_t per frame. [`latent`] says what such codes are worth.
//!
//! Beside it [`spline_transformer`]: whole sequences as a few control points of a latent curve (thesis chapter 3), and
//! [`motion_spline`]: a robot's motion as such curves, to be edited by them.

pub mod dataset;
pub mod latent;
pub mod loss;
pub mod motion_spline;
pub mod plan;
pub mod prior;
pub mod reconstruction;
pub mod spline_transformer;
pub mod statistics;
pub mod train_prior;
pub mod vae;

pub use dataset::PriorClip;
pub use plan::PriorPlan;
pub use prior::MotionPrior;
pub use reconstruction::ReconstructionReport;
pub use statistics::FeatureStatistics;
pub use train_prior::{PriorMetrics, PriorTrainer};
