//! Cubic Bézier curves (thesis Algorithm 3), one segment or several one after the other.

use serde::{Deserialize, Serialize};

use super::error::SplineError;

/// Relation of neighbouring segments to the control point where they meet.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Joints {
    /// Each segment has four control points of its own (thesis 3.3), so each can be moved alone; the curve may jump.
    #[default]
    Separate,
    /// A segment begins where the one before it ends: three more control points for each, and no jump.
    Shared,
}

/// Cubic segments over equal parts of u in `[0, 1]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct CubicBezier {
    segments: usize,
    joints: Joints,
}

impl Default for CubicBezier {
    /// Returns one segment.
    fn default() -> Self {
        Self { segments: 1, joints: Joints::Separate }
    }
}

impl CubicBezier {
    /// # Errors
    /// No segments.
    pub fn new(segments: usize, joints: Joints) -> Result<Self, SplineError> {
        if segments == 0 {
            return Err(SplineError::NoSegments);
        }
        Ok(Self { segments, joints })
    }

    /// Returns the number of control points.
    pub fn control_points(&self) -> usize {
        match self.joints {
            Joints::Separate => 4 * self.segments,
            Joints::Shared => 3 * self.segments + 1,
        }
    }

    /// Returns the control points of a segment, from 0.
    pub fn control_points_of(&self, segment: usize) -> std::ops::Range<usize> {
        let first = match self.joints {
            Joints::Separate => 4 * segment,
            Joints::Shared => 3 * segment,
        };
        first..first + 4
    }

    /// Returns the weight of every control point at `u`, or the `derivative`-th derivative of the weights by u. At a
    /// joint of two segments it is the later one's.
    ///
    /// # Errors
    /// `u` is outside of `[0, 1]`.
    pub fn weights(&self, u: f64, derivative: usize) -> Result<Vec<f64>, SplineError> {
        if !(0.0..=1.0).contains(&u) {
            return Err(SplineError::OutOfDomain { t: u, from: 0.0, to: 1.0 });
        }
        let along = u * self.segments as f64;
        let segment = (along as usize).min(self.segments - 1);
        let t = along - segment as f64;
        let s = 1.0 - t;
        let bernstein = match derivative {
            0 => [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t],
            1 => [-3.0 * s * s, 3.0 * s * s - 6.0 * s * t, 6.0 * s * t - 3.0 * t * t, 3.0 * t * t],
            2 => [6.0 * s, 6.0 * t - 12.0 * s, 6.0 * s - 12.0 * t, 6.0 * t],
            3 => [-6.0, 18.0, -18.0, 6.0],
            _ => [0.0; 4],
        };
        let mut out = vec![0.0; self.control_points()];
        let faster = (self.segments as f64).powi(derivative.min(4) as i32);
        for (weight, value) in out[self.control_points_of(segment)].iter_mut().zip(bernstein) {
            *weight = value * faster;
        }
        Ok(out)
    }
}

/// A [`CubicBezier`] as files have it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    segments: usize,
    #[serde(default)]
    joints: Joints,
}

impl TryFrom<Written> for CubicBezier {
    type Error = SplineError;

    fn try_from(written: Written) -> Result<Self, SplineError> {
        Self::new(written.segments, written.joints)
    }
}

impl From<CubicBezier> for Written {
    fn from(curve: CubicBezier) -> Self {
        Self { segments: curve.segments, joints: curve.joints }
    }
}
