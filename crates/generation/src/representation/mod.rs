//! Motion as rows of 7 + 2j numbers in the heading frame (thesis 5.2), and back.
//!
//! The main path: [`FeatureMatrix::from_clip`] → [`Standardizer`] → networks → [`FeatureMatrix::to_clip`]. The rate is
//! HumanML3D's 20 Hz; clips of any rate come in, clips of any rate go out.

mod analysis;
mod matrix;
mod standardizer;
mod synthesis;

pub use matrix::{FeatureMatrix, RepresentationSpec};
pub use standardizer::Standardizer;
