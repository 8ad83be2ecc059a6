//! Floor 6: chapter 2, simulation augmentation.
//!
//! The main path: logs of a robot ([`logs`]) and its simulation are a [`lifelike_sim::trace::Trace`] → the gap between both
//! ([`gap`]) → a network that predicts it from the simulated state, block by block ([`model`], learned by [`training`]) → one file
//! ([`Augmentation`]) that corrects traces, and any simulation as a [`lifelike_sim::StateCorrection`] ([`correction`]).
//! [`identification`] is the classical alternative: the parameters of an actuator's model by least squares.

pub mod augmentation;
pub mod correction;
pub mod error;
pub mod gap;
pub mod identification;
pub mod logs;
pub mod model;
pub mod references;
pub mod replay;
pub mod training;

pub use augmentation::{Augmentation, Feedback};
pub use correction::ActuatorCorrection;
pub use error::AugmentationError;

/// The README's example, which runs as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
