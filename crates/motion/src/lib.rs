//! Floor 1: motion as data.
//!
//! The main path: bytes → [`formats`] → [`SourceClip`] (the human skeleton it came with) → [`retarget`] →
//! [`MotionClip`] (a character's joints by name, SI units; kept in a [`container`], gathered by [`dataset`]) →
//! [`features`] (thesis eq. 4.1) → [`window`] (eq. 4.2), at any rate by [`resample`]. [`edit`] makes clips from clips
//! (thesis 4.3.4: direction).

pub mod clip;
pub mod contacts;
pub mod container;
pub mod dataset;
pub mod edit;
pub mod error;
pub mod feasibility;
pub mod features;
#[cfg(test)]
mod fixtures;
pub mod formats;
pub mod keyframes;
pub mod resample;
pub mod retarget;
pub mod source;
pub mod window;

pub use clip::{Caption, Contacts, MotionClip, Provenance};
pub use error::MotionError;
pub use features::{FeatureLayout, Frame};
pub use source::{Skeleton, SourceClip};
pub use window::WindowSpec;
