//! Uniform cubic B-splines through rows at a constant rate.

use lifelike_nn::spline::BSpline;
use nalgebra::{Cholesky, DMatrix};

/// Weight of second differences of control points: decides where rows do not (a motion of few rows), too small to
/// matter where they do.
const STIFFNESS: f64 = 1e-6;

/// Weights of control points in rows, and of their derivative by time.
#[derive(Debug, Clone)]
pub(super) struct Basis {
    /// `[rows, control points]`: values and derivatives (1/s).
    weights: [DMatrix<f64>; 2],
}

impl Basis {
    /// Returns the basis of `rows` rows, a knot about every `knot_seconds`.
    pub(super) fn new(rows: usize, fps: f64, knot_seconds: f64) -> Self {
        let seconds = rows.saturating_sub(1) as f64 / fps;
        let spans = (seconds / knot_seconds - 1e-6).ceil().max(1.0) as usize;
        let points = spans + 3;
        let spline = BSpline::new(3, points).ok();
        let last = rows.saturating_sub(1).max(1) as f64;
        let of = |derivative: usize| {
            // The curve's parameter goes from 0 to 1.
            let scale = if derivative == 1 && seconds > 0.0 { 1.0 / seconds } else { (1 - derivative) as f64 };
            let mut matrix = DMatrix::zeros(rows, points);
            for row in 0..rows {
                let weights = spline.as_ref().and_then(|s| s.weights((row as f64 / last).min(1.0), derivative).ok());
                for (column, weight) in weights.unwrap_or_default().into_iter().enumerate() {
                    matrix[(row, column)] = scale * weight;
                }
            }
            matrix
        };
        Self { weights: [of(0), of(1)] }
    }

    pub(super) fn control_points(&self) -> usize {
        self.weights[0].ncols()
    }

    /// Returns how many control points the first rows settle: those of the spans that lie whole within them.
    pub(super) fn settled(&self, rows: usize) -> usize {
        let (last, spans) = (self.weights[0].nrows().saturating_sub(1).max(1), self.control_points() - 3);
        let whole = (rows.saturating_sub(1) as f64 / last as f64 * spans as f64 + 1e-6).floor() as usize;
        if whole == 0 { 0 } else { whole.min(spans) + 3 }
    }

    /// Returns the control points on which a row depends: where they are equal, the curve stands there.
    pub(super) fn around(&self, row: usize) -> std::ops::Range<usize> {
        let row = self.weights[0].row(row.min(self.weights[0].nrows().saturating_sub(1)));
        let first = row.iter().position(|weight| *weight > 0.0).unwrap_or(0);
        let last = row.iter().rposition(|weight| *weight > 0.0).unwrap_or(0);
        first..last + 1
    }

    /// Returns the control points of the curves nearest to the rows, `[rows, curves]`, by least squares. Fewer rows than
    /// the basis has are its first ones; the curves go on straight where no row holds them.
    pub(super) fn fit(&self, rows: &[f64], curves: usize) -> Vec<f32> {
        let count = (rows.len() / curves.max(1)).min(self.weights[0].nrows());
        let (weights, points) = (self.weights[0].rows(0, count), self.control_points());
        let mut normal = weights.tr_mul(&weights);
        for first in 0..points - 2 {
            for (i, a) in [1.0, -2.0, 1.0].into_iter().enumerate() {
                for (j, b) in [1.0, -2.0, 1.0].into_iter().enumerate() {
                    normal[(first + i, first + j)] += STIFFNESS * a * b;
                }
            }
        }
        // A single row says nothing about the slope.
        (0..points).for_each(|i| normal[(i, i)] += 1e-9);
        let rows = DMatrix::from_row_slice(count, curves, rows);
        let right = weights.tr_mul(&rows);
        let solved =
            Cholesky::new(normal).map_or_else(|| DMatrix::zeros(points, curves), |factor| factor.solve(&right));
        row_major(&solved)
    }

    /// Returns the curves (0) or their derivatives by time (1) at every row.
    pub(super) fn evaluate(&self, points: &[f32], curves: usize, derivative: usize) -> Vec<f32> {
        let points = points.iter().map(|x| f64::from(*x));
        let points = DMatrix::from_row_iterator(self.control_points(), curves, points);
        row_major(&(&self.weights[derivative] * points))
    }

    /// Returns the transpose of [`Self::evaluate`].
    pub(super) fn transposed(&self, rows: &[f32], curves: usize, derivative: usize) -> Vec<f32> {
        let weights = &self.weights[derivative];
        let rows = DMatrix::from_row_iterator(weights.nrows(), curves, rows.iter().map(|x| f64::from(*x)));
        row_major(&weights.tr_mul(&rows))
    }
}

fn row_major(matrix: &DMatrix<f64>) -> Vec<f32> {
    matrix.transpose().iter().map(|x| *x as f32).collect()
}
