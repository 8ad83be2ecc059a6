//! Floor 2: the robot — what training, evaluation, the studio and the hardware share.
//!
//! It lies BELOW the simulation, so that one observation builder, one actuator model and one action definition serve all
//! of them: a policy fed with another layout than it was trained on cannot be written down. No training framework stands
//! below this line.
//!
//! The main path: [`Robot::load`] → [`Controller`] (measured state and a [`ReferenceStream`] in, joint targets out), which
//! owns [`observation`] (state and reference → policy input), the frozen [`network`]s and [`action`] (policy output →
//! joint targets) → [`actuator`] (targets → torques). Motion for it comes from [`clips`].

pub mod action;
pub mod actuator;
pub mod clips;
pub mod controller;
pub mod error;
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
pub use observation::{AnchorSpec, MeasuredState, ObservationInputs, ObservationSpec, ReferenceSpec};
pub use profile::{ActuatorGroup, Profile};
pub use readiness::{Problem, Readiness, Severity, Shapes};
pub use reference::{Alignment, ClipPlayer, LatentEncoder, ReferenceLibrary, ReferenceStream};
pub use robot::Robot;

/// The README's example, which runs as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
