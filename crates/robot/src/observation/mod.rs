//! Inputs of a policy: the one observation builder of the whole project.
//!
//! [`ObservationSpec`] is the layout, [`ObservationInputs`] what one observation is made of; each part of it is declared
//! once, in `part`.

mod chain;
mod inputs;
mod memory;
mod part;
mod spec;

pub use chain::Chain;
pub use inputs::{MeasuredState, ObservationInputs};
pub use memory::Memory;
pub use part::{Part, Sensor, Source};
pub use spec::{AnchorSpec, ObservationSpec, ReferenceSpec};
