//! Floor 5: learned representations of motion.
//!
//! The motion prior (thesis 4.2.1): a latent code for the second of motion around every frame.
//!
//! The main path: clips' frames → [`dataset::Windows`] (eq. 4.2, normalised by [`statistics::FeatureStatistics`]) →
//! [`vae::MotionVae`] trained by [`train_prior::PriorTrainer`] on eqs. 4.3-4.4 ([`loss`]) → [`prior::MotionPrior`], one file
//! that encodes any clip of the same character into one z_t per frame. [`latent`] says what such codes are worth.
//!
//! Beside it [`spline_transformer`]: whole sequences as a few control points of a latent curve (thesis chapter 3), and
//! [`motion_spline`]: a robot's motion as such curves, to be edited by them; [`spline_prior`] makes control points the codes of the
//! same windows as the VAE's: another [`prior::MotionPrior`].

pub mod dataset;
mod error;
pub mod latent;
pub mod loss;
pub mod motion_spline;
pub mod plan;
pub mod prior;
pub mod reconstruction;
pub mod spline_prior;
pub mod spline_transformer;
mod standard;
pub mod statistics;
pub mod train_prior;
pub mod vae;
pub mod window_plan;

pub use dataset::PriorClip;
pub use error::RepresentationError;
pub use plan::PriorPlan;
pub use prior::{MotionPrior, Recipe};
pub use reconstruction::ReconstructionReport;
pub use spline_prior::SplinePriorPlan;
pub use statistics::FeatureStatistics;
pub use train_prior::{PriorMetrics, PriorTrainer};
pub use window_plan::WindowPlan;
