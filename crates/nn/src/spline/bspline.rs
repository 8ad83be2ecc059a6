//! Uniform B-splines of any degree (thesis eqs. 3.1 and 3.2; Cox-de Boor; Piegl & Tiller 1997, chapter 2).
//!
//! The thesis' k is the ORDER, degree + 1: it makes its statements true. These are k control points per span, and a
//! domain from t_{k-1} to t_{n+1}.

use super::error::SplineError;

/// Uniform knots through and through; the domain is `[0, 1]`. The curve passes through no control point in general.
#[derive(Debug, Clone, PartialEq)]
pub struct BSpline {
    degree: usize,
    knots: Vec<f64>,
}

impl BSpline {
    /// Returns a curve of this degree.
    ///
    /// # Errors
    /// Not more control points than the degree.
    pub fn new(degree: usize, control_points: usize) -> Result<Self, SplineError> {
        if control_points <= degree {
            return Err(SplineError::TooFewControlPoints { degree, control_points });
        }
        let spans = (control_points - degree) as f64;
        let knots = (0..control_points + degree + 1).map(|i| (i as f64 - degree as f64) / spans).collect();
        Ok(Self { degree, knots })
    }

    /// Returns the number of control points.
    pub fn control_points(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// Returns the weight of every control point at `t`, or the `derivative`-th derivative of the weights by t. At a knot where a
    /// derivative jumps it is the value after it; at the end of the domain the one before.
    ///
    /// # Errors
    /// `t` is outside of the domain.
    pub fn weights(&self, t: f64, derivative: usize) -> Result<Vec<f64>, SplineError> {
        let mut out = vec![0.0; self.control_points()];
        let span = self.span(t)?;
        if derivative <= self.degree {
            let low = self.degree - derivative;
            let mut values = self.nonzero(span, t, low);
            for degree in low + 1..=self.degree {
                values = self.raised(span, &values, degree);
            }
            out[span - self.degree..=span].copy_from_slice(&values);
        }
        Ok(out)
    }

    /// Returns the span of length above zero that holds `t`: the last such that begins at or before it.
    fn span(&self, t: f64) -> Result<usize, SplineError> {
        if !(0.0..=1.0).contains(&t) {
            return Err(SplineError::OutOfDomain { t });
        }
        let last = self.control_points();
        // At the end of the domain, step back over the knots that stand there.
        let after =
            if t < 1.0 { self.knots.partition_point(|k| *k <= t) } else { self.knots.partition_point(|k| *k < t) };
        Ok((after - 1).clamp(self.degree, last - 1))
    }

    /// Returns the degree + 1 functions N that are not zero on `span`, by the triangular scheme in which no term is 0/0.
    fn nonzero(&self, span: usize, t: f64, degree: usize) -> Vec<f64> {
        let mut n = vec![1.0];
        for p in 1..=degree {
            let mut next = vec![0.0; p + 1];
            for (r, value) in n.iter().enumerate() {
                let (left, right) = (self.knots[span + 1 + r - p], self.knots[span + 1 + r]);
                let share = value / (right - left);
                next[r] += (right - t) * share;
                next[r + 1] += (t - left) * share;
            }
            n = next;
        }
        n
    }

    /// Returns one derivative: from functions of one degree less, N' = p (N_i / (t_{i+p} − t_i) − N_{i+1} / (t_{i+p+1} − t_{i+1})).
    fn raised(&self, span: usize, lower: &[f64], degree: usize) -> Vec<f64> {
        let mut out = vec![0.0; degree + 1];
        for (r, value) in lower.iter().enumerate() {
            let first = span + 1 + r - degree;
            let share = degree as f64 * value / (self.knots[first + degree] - self.knots[first]);
            out[r] -= share;
            out[r + 1] += share;
        }
        out
    }
}
