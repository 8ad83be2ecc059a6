//! Plan of a motion spline's training, a TOML file.

use std::path::PathBuf;

use crate::RepresentationError;
use crate::spline_transformer::{Method, SequencePlan};
use lifelike_train::limits::wrong;
use lifelike_train::plan;

/// A training of a [`super::MotionSpline`].
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotionSplinePlan {
    /// Robot: a built-in name, or an MJCF or URDF file.
    pub robot: String,
    /// Clips to train on: files, folders, patterns.
    ///
    /// Captured motion and keyframes are retargeted to the robot.
    pub clips: Vec<PathBuf>,
    /// Learning from the mirror image of every clip too, by the robot's own symmetry.
    #[serde(default)]
    pub mirror: bool,
    /// Clips on which the loss is reported during training.
    #[serde(default)]
    pub validation: Vec<PathBuf>,
    /// Clips of the errors at the end, never trained on.
    #[serde(default)]
    pub test: Vec<PathBuf>,
    /// Frame rate of the network's motion (Hz).
    ///
    /// Whatever is faster than half of it is detail, which editing carries along.
    #[serde(default = "frame_rate")]
    #[schemars(extend("unit" = "Hz"), range(min = 1.0, max = 1000.0))]
    pub frame_rate: f64,
    /// Frames of one segment, which is one curve.
    #[serde(default = "frames")]
    #[schemars(extend("unit" = "frames"), range(min = 8, max = 4096))]
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
        plan::check("", self)?;
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
