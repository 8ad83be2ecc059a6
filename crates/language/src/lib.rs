//! Floor 2: motion with words.
//!
//! A data set of captioned clips is a folder with an index ([`dataset`]). [`facts`] are the testable content of a
//! caption; [`checks`] tests them on a clip by forward kinematics. A [`grammar`] generates our own data without motion
//! capture. A [`script`] is a sentence in free words as actions of the grammar.

pub mod captures;
pub mod checks;
pub mod dataset;
pub mod error;
pub mod facts;
#[cfg(test)]
mod fixtures;
pub mod grammar;
pub mod humanml3d;
mod mirror_caption;
pub mod posture;
pub mod script;
mod touch;

pub use dataset::{CaptionedSet, Entry, Split};
pub use error::LanguageError;
pub use facts::Facts;
use lifelike_checkpoint::FromInput;
pub use mirror_caption::mirror_caption;
pub use posture::Posture;
pub use touch::Touch;

/// The README's example is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
