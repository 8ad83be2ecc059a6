//! Floor 6: chapter 2, simulation augmentation.
//!
//! The main path: [`logs`] of a robot and its simulation → [`lifelike_sim::trace::Trace`] → [`gap`] → [`model`],
//! trained by [`training`] → [`Augmentation`].
//!
//! The network predicts the gap between both from the simulated state, block by block. An [`Augmentation`] is one file
//! that corrects traces. As a [`lifelike_sim::StateCorrection`] it corrects any simulation ([`correction`]).
//! [`identification`] is the classical alternative: the parameters of an actuator's model by least squares.

pub mod augmentation;
pub mod correction;
pub mod error;
pub mod gap;
pub mod identification;
pub mod logs;
mod loss;
pub mod model;
pub mod references;
pub mod replay;
pub mod training;

pub use augmentation::{Augmentation, Feedback};
pub use correction::ActuatorCorrection;
pub use error::AugmentationError;
use lifelike_checkpoint::FromInput;

/// The README's example, which runs as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
