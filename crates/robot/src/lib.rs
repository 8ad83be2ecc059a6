//! Floor 2: the robot, shared by training, evaluation, simulation and hardware.
//!
//! It is below the simulation, so that one observation builder, one actuator model and one action definition serve all
//! of them. A policy runs only with the layout of its training. The crate needs no training framework.
//!
//! The main path: [`Robot::load`] → [`Controller`] → [`actuator`] (targets → torques). A [`Controller`] reads the
//! measured state and a [`ReferenceStream`] and returns joint targets. It owns [`observation`] (state and reference →
//! policy input), the frozen [`network`]s and [`action`] (policy output → joint targets). Its motion comes from
//! [`clips`].

pub mod action;
pub mod actuator;
pub mod clips;
pub mod controller;
pub mod error;
pub mod get_up;
mod guess;
pub mod load;
pub mod nearest;
pub mod network;
pub mod observation;
pub mod profile;
pub mod readiness;
pub mod reference;
pub mod robot;
mod standing;

pub use action::{ActionMap, ActionSpec};
pub use actuator::{ActuatorParameters, ActuatorSet};
pub use clips::{LeftOut, LoadedClips};
pub use controller::{Controller, ControllerFile, ControllerState};
pub use error::RobotError;
pub use get_up::{GetUp, GetUpScript};
pub use lifelike_checkpoint::FromInput;
pub use observation::{AnchorSpec, MeasuredState, ObservationInputs, ObservationSpec, ReferenceSpec};
pub use profile::{ActuatorGroup, Profile};
pub use readiness::{Problem, Readiness, Severity, Shapes, level_ground};
pub use reference::{Alignment, ClipPlayer, LatentEncoder, ReferenceLibrary, ReferenceStream};
pub use robot::Robot;

/// The README's example, which runs as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
