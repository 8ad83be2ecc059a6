//! Either kind of spline on u in `[0, 1]`, sampled and evaluated.

use serde::{Deserialize, Serialize};

use super::bezier::CubicBezier;
use super::bspline::BSpline;
use super::error::SplineError;

/// A curve of some number of control points, whichever its kind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Spline {
    /// Cubic Bézier segments.
    Bezier(CubicBezier),
    /// A B-spline; its domain is mapped to `[0, 1]`.
    BSpline(BSpline),
}

impl Default for Spline {
    /// Returns the thesis': one cubic Bézier segment of four control points.
    fn default() -> Self {
        Self::Bezier(CubicBezier::default())
    }
}

impl Spline {
    /// Returns the number of control points.
    pub fn control_points(&self) -> usize {
        match self {
            Self::Bezier(curve) => curve.control_points(),
            Self::BSpline(curve) => curve.control_points(),
        }
    }

    /// Returns the weights of all control points at each of `positions`, row-major `[positions, control points]`, or their
    /// `derivative`-th derivative by u (1: velocities, per length of the whole curve).
    ///
    /// # Errors
    /// A position outside of `[0, 1]`.
    pub fn weights(&self, positions: &[f64], derivative: usize) -> Result<Vec<f64>, SplineError> {
        let mut out = Vec::with_capacity(positions.len() * self.control_points());
        for &u in positions {
            match self {
                Self::Bezier(curve) => out.extend(curve.weights(u, derivative)?),
                Self::BSpline(curve) => {
                    if !(0.0..=1.0).contains(&u) {
                        return Err(SplineError::OutOfDomain { t: u, from: 0.0, to: 1.0 });
                    }
                    let (from, to) = curve.domain();
                    // Exact at both ends, and never beyond them.
                    let t = (from * (1.0 - u) + to * u).clamp(from, to);
                    let faster = (to - from).powi(derivative.min(BSpline::MAX_DEGREE + 1) as i32);
                    out.extend(curve.weights(t, derivative)?.into_iter().map(|weight| weight * faster));
                }
            }
        }
        Ok(out)
    }

    /// Returns the curve at `samples` positions, evenly from its beginning to its end (thesis Algorithm 3).
    ///
    /// # Shapes
    /// `[B, control points, d]` to `[B, samples, d]`.
    ///
    /// # Errors
    /// Numbers that are not those of whole curves.
    pub fn evaluate(&self, control_points: &[f32], d: usize, samples: usize) -> Result<Vec<f32>, SplineError> {
        self.evaluate_at(control_points, d, &uniform(samples), 0)
    }

    /// Returns the curve, or its `derivative`-th derivative by u, anywhere.
    ///
    /// # Shapes
    /// `[B, control points, d]` to `[B, positions, d]`.
    ///
    /// # Errors
    /// Numbers that are not those of whole curves, or a position outside of `[0, 1]`.
    pub fn evaluate_at(
        &self,
        control_points: &[f32],
        d: usize,
        positions: &[f64],
        derivative: usize,
    ) -> Result<Vec<f32>, SplineError> {
        let expected = self.control_points();
        if d == 0 || !control_points.len().is_multiple_of(expected * d) {
            return Err(SplineError::WrongControlPoints { expected, got: control_points.len() / d.max(1) });
        }
        let weights = self.weights(positions, derivative)?;
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

    /// Returns the gradient by the control points, from that by what [`Self::evaluate_at`] returned of them.
    ///
    /// # Shapes
    /// `[B, positions, d]` to `[B, control points, d]`.
    ///
    /// # Errors
    /// A position outside of `[0, 1]`.
    pub fn by_control_points(&self, gradient: &[f32], d: usize, positions: &[f64]) -> Result<Vec<f32>, SplineError> {
        let (count, weights) = (self.control_points(), self.weights(positions, 0)?);
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
