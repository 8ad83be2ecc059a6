//! The cubic Bézier curve of the thesis (Algorithm 3).

use serde::{Deserialize, Serialize};

use super::error::SplineError;

/// One cubic segment over u in `[0, 1]`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct CubicBezier;

impl CubicBezier {
    /// Number of control points.
    pub const CONTROL_POINTS: usize = 4;

    /// Returns the weight of every control point at `u`.
    ///
    /// # Errors
    /// `u` is outside of `[0, 1]`.
    pub fn weights(self, u: f64) -> Result<[f64; Self::CONTROL_POINTS], SplineError> {
        if !(0.0..=1.0).contains(&u) {
            return Err(SplineError::OutOfDomain { t: u });
        }
        let (t, s) = (u, 1.0 - u);
        Ok([s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t])
    }

    /// The weights at each of `positions`, row-major `[positions, control points]`.
    fn all_weights(self, positions: &[f64]) -> Result<Vec<f64>, SplineError> {
        let mut out = Vec::with_capacity(positions.len() * Self::CONTROL_POINTS);
        for &u in positions {
            out.extend(self.weights(u)?);
        }
        Ok(out)
    }

    /// Returns the curve at positions (thesis Algorithm 3).
    ///
    /// # Shapes
    /// `[B, control points, d]` to `[B, positions, d]`.
    ///
    /// # Errors
    /// Numbers that are not those of whole curves, or a position outside of `[0, 1]`.
    pub fn evaluate(self, control_points: &[f32], d: usize, positions: &[f64]) -> Result<Vec<f32>, SplineError> {
        let expected = Self::CONTROL_POINTS;
        if d == 0 || !control_points.len().is_multiple_of(expected * d) {
            return Err(SplineError::WrongControlPoints { expected, got: control_points.len() / d.max(1) });
        }
        let weights = self.all_weights(positions)?;
        let mut out = vec![0.0; control_points.len() / expected * positions.len()];
        for (out, points) in out.chunks_mut((positions.len() * d).max(1)).zip(control_points.chunks(expected * d)) {
            for (out, weights) in out.chunks_exact_mut(d).zip(weights.chunks_exact(expected)) {
                for (weight, point) in weights.iter().zip(points.chunks_exact(d)) {
                    out.iter_mut().zip(point).for_each(|(out, x)| *out += *weight as f32 * x);
                }
            }
        }
        Ok(out)
    }

    /// Returns the gradient by the control points, from that by what [`Self::evaluate`] returned of them.
    ///
    /// # Shapes
    /// `[B, positions, d]` to `[B, control points, d]`.
    ///
    /// # Errors
    /// A position outside of `[0, 1]`.
    pub fn by_control_points(self, gradient: &[f32], d: usize, positions: &[f64]) -> Result<Vec<f32>, SplineError> {
        let (count, weights) = (Self::CONTROL_POINTS, self.all_weights(positions)?);
        let mut out = vec![0.0; gradient.len() / positions.len().max(1) * count];
        for (out, gradient) in out.chunks_mut(count * d).zip(gradient.chunks((positions.len() * d).max(1))) {
            for (gradient, weights) in gradient.chunks_exact(d).zip(weights.chunks_exact(count)) {
                for (weight, out) in weights.iter().zip(out.chunks_exact_mut(d)) {
                    out.iter_mut().zip(gradient).for_each(|(out, x)| *out += *weight as f32 * x);
                }
            }
        }
        Ok(out)
    }
}

/// Returns `samples` positions, evenly from 0 to 1; one alone stands at 0 (as `linspace` has it).
pub fn uniform(samples: usize) -> Vec<f64> {
    let last = samples.saturating_sub(1).max(1) as f64;
    (0..samples).map(|i| i as f64 / last).collect()
}

/// A [`CubicBezier`] as files have it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    bezier: Segments,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Segments {
    segments: usize,
    #[serde(default = "separate")]
    joints: String,
}

fn separate() -> String {
    "separate".into()
}

impl TryFrom<Written> for CubicBezier {
    type Error = SplineError;

    fn try_from(written: Written) -> Result<Self, SplineError> {
        let Segments { segments, joints } = written.bezier;
        if segments != 1 || joints != separate() {
            return Err(SplineError::OtherCurve { segments, joints });
        }
        Ok(Self)
    }
}

impl From<CubicBezier> for Written {
    fn from(_: CubicBezier) -> Self {
        Self { bezier: Segments { segments: 1, joints: separate() } }
    }
}
