//! Plan of a motion spline's training, a TOML file.

use std::path::PathBuf;

use crate::RepresentationError;
use crate::spline_transformer::{Method, SequencePlan};
use lifelike_train::limits::{range, whole, wrong};

/// A training of a [`super::MotionSpline`].
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotionSplinePlan {
    /// A built-in robot's name, or its MJCF or URDF file.
    pub robot: String,
    /// Clips to train on: files, folders, patterns. Captured motion and keyframes are retargeted to the robot.
    pub clips: Vec<PathBuf>,
    /// Learn from the mirror image of every clip too, by the robot's own symmetry.
    #[serde(default)]
    pub mirror: bool,
    /// Clips that the loss is watched on.
    #[serde(default)]
    pub validation: Vec<PathBuf>,
    /// Clips of the errors at the end. Never trained on.
    #[serde(default)]
    pub test: Vec<PathBuf>,
    /// Frames per second that the network sees. Whatever is faster than half of it is detail, which editing carries along.
    #[serde(default = "frame_rate")]
    pub frame_rate: f64,
    /// Frames of one segment, so of one curve.
    #[serde(default = "frames")]
    pub frames: usize,
    /// Network and training.
    #[serde(default)]
    pub training: SequencePlan,
}

fn frame_rate() -> f64 {
    25.0
}

fn frames() -> usize {
    50
}

impl MotionSplinePlan {
    /// Checks every range.
    ///
    /// # Errors
    /// The first key out of range.
    pub fn check(&self) -> Result<(), RepresentationError> {
        range("frame_rate", self.frame_rate, 1.0, 1000.0)?;
        whole("frames", self.frames as u64, 8, 4096)?;
        if self.training.method != Method::Spline {
            return Err(
                wrong("training.method", "spline: the others have no control points", self.training.method).into()
            );
        }
        self.training.check()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn plans_say_what_is_wrong() {
        let plan = |text: &str| toml::from_str::<MotionSplinePlan>(&format!("robot = 'lima'\nclips = []\n{text}"));
        assert!(plan("").unwrap().check().is_ok());
        let error = |text: &str| plan(text).unwrap().check().unwrap_err().to_string();
        assert_eq!(error("frames = 4"), "plan: frames: expected 8 to 4096, got 4");
        assert!(error("[training]\nmethod = 'alibi'").contains("no control points"));
        assert!(plan("frame = 3").unwrap_err().to_string().contains("unknown field `frame`"));
    }
}
