//! Learned representations of motion: chapter 3 of the thesis, and chapter 4's motion prior (floor 5).
//!
//! - [`prior`] (4.2.1): a latent code z_t for the second of motion around every frame. Clips → windows → a trained
//!   [`MotionPrior`], one file that encodes any clip of the same character.
//! - [`spline_transformer`] (3.2): whole sequences as a few control points of a latent curve, and the baselines.
//! - [`components`]: principal components, the simple baseline of both.
//! - [`motion_spline`]: a robot's clips as such curves, to be edited by their control points.
//! - [`latent`]: measures of any encoder's codes: search, interpolation, class separation.

pub mod components;
mod error;
pub mod latent;
pub mod motion_spline;
pub mod prior;
pub mod spline_transformer;
pub mod standardizer;

pub use error::RepresentationError;
use lifelike_checkpoint::FromInput;
pub use prior::{MotionPrior, PriorClip, PriorPlan, WindowPlan};

/// The README's examples, run as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
