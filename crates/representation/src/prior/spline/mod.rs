//! The Spline-based Transformer (thesis chapter 3) in the place of the β-VAE (4.2.1): the same windows, and z_t are the control
//! points of their latent curve. The thesis names both and does not try this.
//!
//! The main path: a [`SplinePriorPlan`] and clips → [`WindowSequences`] → [`crate::spline_transformer::SequenceTrainer`] →
//! [`super::MotionPrior::of_spline`], a prior like any other.
//!
//! A VAE's codes are about standard normal, because its loss asks for it. Control points have no scale, and a policy's
//! inputs should have one. Every number of z_t is therefore a control point's less its mean and by its standard
//! deviation over the training windows. Both are part of the prior. Nothing keeps codes of motion that was never
//! trained on near those of motion that was.

mod coder;
mod plan;
mod sequences;

pub use plan::SplinePriorPlan;
pub use sequences::WindowSequences;

pub use coder::SplineCoder;
