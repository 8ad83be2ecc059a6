//! The layout of a row, and rows of one motion.

use std::ops::Range;

use lifelike_motion::FeatureLayout;

use crate::{FromInput, GenerationError};

/// Layout of a row: rate and joints.
///
/// # Shapes
/// A row of `7 + 2j` numbers: root height (m), root velocity on the ground and yaw rate to the next row (m/s in the
/// heading frame, rad/s). Then come the world's up direction in the root's frame (3), joint angles (rad or m), joint
/// velocities (rad/s or m/s).
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RepresentationSpec {
    /// Rows per second.
    pub fps: f64,
    /// Joint names, in column order.
    pub joint_names: Vec<String>,
}

impl RepresentationSpec {
    /// HumanML3D's rate (Hz).
    pub const FPS: f64 = 20.0;
    /// Root height (m).
    pub const HEIGHT: usize = 0;
    /// Root linear velocity xy in the heading frame (m/s).
    pub const VELOCITY: Range<usize> = 1..3;
    /// Root yaw rate (rad/s).
    pub const YAW_RATE: usize = 3;
    /// Up direction in the root's frame.
    pub const UP: Range<usize> = 4..7;

    /// Returns the layout for these joints at 20 Hz.
    pub fn new(joint_names: Vec<String>) -> Self {
        Self { fps: Self::FPS, joint_names }
    }

    /// Returns the layout for a robot's joints at 20 Hz.
    pub fn of(layout: &FeatureLayout) -> Self {
        Self::new(layout.joints.clone())
    }

    /// Returns j.
    pub fn joints(&self) -> usize {
        self.joint_names.len()
    }

    /// Returns the length of a row, 7 + 2j.
    pub fn width(&self) -> usize {
        7 + 2 * self.joints()
    }

    /// Returns the columns of the joint angles.
    pub fn angles(&self) -> Range<usize> {
        7..7 + self.joints()
    }

    /// Returns the columns of the joint velocities.
    pub fn velocities(&self) -> Range<usize> {
        7 + self.joints()..self.width()
    }

    /// Checks that `what` is for motion of this layout.
    ///
    /// # Errors
    /// [`GenerationError::Input`] with both layouts.
    pub fn expect(&self, what: &str, other: &Self) -> Result<(), GenerationError> {
        if self == other {
            return Ok(());
        }
        let text = |spec: &Self| format!("{} at {} Hz", spec.joint_names.join(", "), spec.fps);
        Err(GenerationError::mismatch(what, text(self), text(other)))
    }

    /// Checks rate and names.
    ///
    /// # Errors
    /// [`GenerationError::Input`] for a rate that is not positive or a name that stands twice.
    pub fn check(&self) -> Result<(), GenerationError> {
        if !(self.fps.is_finite() && self.fps > 0.0) {
            return Err(GenerationError::mismatch("rate of the representation", "a positive number", self.fps));
        }
        let mut seen = std::collections::BTreeSet::new();
        match self.joint_names.iter().find(|name| !seen.insert(name.as_str())) {
            Some(twice) => Err(GenerationError::mismatch("joints of the representation", "each once", twice)),
            None => Ok(()),
        }
    }
}

/// Rows of one motion.
#[derive(Debug, Clone, PartialEq)]
pub struct FeatureMatrix {
    /// `[n, width]`, row-major, in SI units.
    pub rows: Vec<f32>,
    /// Number of rows.
    pub n: usize,
    /// Length of a row, 7 + 2j.
    pub width: usize,
}

impl FeatureMatrix {
    /// Returns rows of this width.
    ///
    /// # Errors
    /// [`GenerationError::Input`] for numbers that make no whole rows.
    pub fn new(rows: Vec<f32>, width: usize) -> Result<Self, GenerationError> {
        if width == 0 || !rows.len().is_multiple_of(width) {
            let what = "numbers of a feature matrix";
            return Err(GenerationError::mismatch(what, format!("rows of {width}"), rows.len()));
        }
        Ok(Self { n: rows.len() / width, rows, width })
    }

    /// Returns one row.
    pub fn row(&self, at: usize) -> &[f32] {
        &self.rows[at * self.width..(at + 1) * self.width]
    }
}
