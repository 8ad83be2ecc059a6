//! Floor 1: motion as data.
//!
//! The main path: bytes → [`formats`] → [`SourceClip`] (with its human skeleton) → [`retarget`] → [`MotionClip`] (a
//! character's joints by name, SI units) → [`features`] (thesis eq. 4.1) → [`window`] (eq. 4.2). A [`container`] stores
//! clips, [`dataset`] collects them, and [`resample`] changes their rate. [`edit`] makes clips from clips (thesis
//! 4.3.4: direction).
//!
//! ```
//! use std::path::Path;
//! use lifelike_motion::formats::{self, ReadOptions, bvh};
//!
//! let text = b"HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\nEnd Site\n{\nOFFSET 0 1.7 0\n}\n}\n\
//!     MOTION\nFrames: 2\nFrame Time: 0.01\n0 0 0\n0 0 0.1\n";
//! let clip = bvh::parse(text, Path::new("slide.bvh"), &ReadOptions { scale: Some(1.0), ..ReadOptions::default() })?;
//! assert_eq!((clip.name.as_str(), clip.len(), clip.fps), ("slide", 2, 100.0));
//! assert!((clip.root_position[1].x - 0.1).abs() < 1e-12, "y up and z forward became z up and x forward");
//!
//! // Which formats are read, as messages and help texts list them.
//! assert!(formats::supported(|_| true).contains(".bvh"));
//! # Ok::<(), lifelike_motion::MotionError>(())
//! ```

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
pub mod lint;
pub mod plausibility;
pub mod resample;
pub mod retarget;
mod roles;
pub mod source;
pub mod window;

pub use clip::{Caption, Contacts, MotionClip, Provenance};
pub use error::MotionError;
pub use features::{FeatureLayout, Frame, FrameRef};
use lifelike_checkpoint::FromInput;
pub use source::{Skeleton, SourceClip};
pub use window::WindowSpec;

/// The README's example, which runs as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
