//! Either kind of spline on u in `[0, 1]`, sampled and evaluated.

use burn::tensor::{Device, Tensor, TensorData};
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

    /// As [`Self::weights`], rounded once, as a tensor `[positions, control points]`.
    ///
    /// # Errors
    /// A position outside of `[0, 1]`.
    pub fn matrix(&self, positions: &[f64], derivative: usize, device: &Device) -> Result<Tensor<2>, SplineError> {
        let values: Vec<f32> = self.weights(positions, derivative)?.into_iter().map(|w| w as f32).collect();
        Ok(Tensor::from_data(TensorData::new(values, [positions.len(), self.control_points()]), device))
    }

    /// Returns the curve at `samples` positions, evenly from its beginning to its end (thesis Algorithm 3).
    ///
    /// # Shapes
    /// `[B, control points, d]` to `[B, samples, d]`.
    ///
    /// # Errors
    /// Another number of control points.
    pub fn evaluate(&self, control_points: Tensor<3>, samples: usize) -> Result<Tensor<3>, SplineError> {
        self.evaluate_at(control_points, &uniform(samples), 0)
    }

    /// Returns the curve, or its `derivative`-th derivative by u, anywhere: one batched matrix product.
    ///
    /// # Shapes
    /// `[B, control points, d]` to `[B, positions, d]`.
    ///
    /// # Errors
    /// Another number of control points, or a position outside of `[0, 1]`.
    pub fn evaluate_at(
        &self,
        control_points: Tensor<3>,
        positions: &[f64],
        derivative: usize,
    ) -> Result<Tensor<3>, SplineError> {
        let got = control_points.dims()[1];
        if got != self.control_points() {
            return Err(SplineError::WrongControlPoints { expected: self.control_points(), got });
        }
        let matrix = self.matrix(positions, derivative, &control_points.device())?;
        Ok(matrix.unsqueeze::<3>().matmul(control_points))
    }
}

/// Returns `samples` positions, evenly from 0 to 1; one alone stands at 0 (as `linspace` has it).
pub fn uniform(samples: usize) -> Vec<f64> {
    let last = samples.saturating_sub(1).max(1) as f64;
    (0..samples).map(|i| i as f64 / last).collect()
}

/// Returns how many samples put `factor − 1` new ones between any two of `samples`. [`uniform`] positions of so many contain the
/// original ones, bit for bit: every `factor`-th. (`factor · samples` of them, as one may want too, meet only at the ends.)
pub fn refined(samples: usize, factor: usize) -> usize {
    samples.saturating_sub(1) * factor.max(1) + samples.min(1)
}
