//! Floor 2: the robot — what training, evaluation, the studio and the hardware share.
//!
//! It lies BELOW the simulation, so that one observation builder, one actuator model and one action definition serve all
//! of them: a policy fed with another layout than it was trained on cannot be written down.
//!
//! The main path: [`Robot::load`] → [`action`] (policy output → joint targets) → [`actuator`] (targets → torques) →
//! [`observation`] (state and reference → policy input).

pub mod action;
pub mod actuator;
pub mod error;
mod guess;
pub mod load;
pub mod observation;
pub mod profile;
pub mod robot;

pub use action::{ActionMap, ActionSpec};
pub use actuator::{ActuatorParameters, ActuatorSet};
pub use error::RobotError;
pub use observation::{AnchorSpec, ObservationInputs, ObservationSpec, ReferenceSpec};
pub use profile::{ActuatorGroup, Profile};
pub use robot::Robot;
