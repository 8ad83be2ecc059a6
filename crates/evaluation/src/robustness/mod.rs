//! Disturbances that a policy withstands (thesis 4.3.3, "Robustness" and "Reactivity"): survival and error against their
//! size.
//!
//! The main path: [`Disturbance`] (with its sizes) → [`sweep`] (an evaluation per size, under
//! [`EpisodeConditions`](super::EpisodeConditions)s with addressed randomness) → [`Robustness`] (curves) → its tables, curves and playbacks.
//! Every size of one disturbance meets the same directions, moments and places, so that curves differ by size alone.

mod curve;
mod disturbance;
mod options;
mod push;
mod stairs;
mod sweep;
mod switches;
mod tables;
#[cfg(test)]
mod tests;
mod trial;

pub use curve::{Point, Robustness, RobustnessCurve};
pub use disturbance::{Disturbance, Part};
pub use options::RobustnessOptions;
pub use stairs::climb;
pub use sweep::sweep;
