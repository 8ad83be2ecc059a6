//! B-splines of any degree on any knot vector (thesis eqs. 3.1 and 3.2; Cox-de Boor; Piegl & Tiller 1997, chapter 2).
//!
//! The thesis' k is the ORDER, degree + 1: it makes its statements true. These are k control points per span, and a
//! domain from t_{k-1} to t_{n+1}. A knot that stands m times has C^{k-m-1}, and a control point on the curve for m =
//! k − 1.

use serde::{Deserialize, Serialize};

use super::error::SplineError;

/// Degree, knots and, by their counts, the number of control points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct BSpline {
    degree: usize,
    knots: Vec<f64>,
}

impl BSpline {
    /// Beyond this the weights of a curve lose all digits, and nobody needs it.
    pub const MAX_DEGREE: usize = 64;

    /// Returns a curve of this degree on `knots`, which do not decrease. Its control points number the
    /// knots less degree + 1.
    ///
    /// # Errors
    /// A degree too high, too few knots, a knot that is not finite, decreases or repeats more than degree + 1 times,
    /// or an empty domain.
    pub fn new(degree: usize, knots: Vec<f64>) -> Result<Self, SplineError> {
        if degree > Self::MAX_DEGREE {
            return Err(SplineError::DegreeTooHigh { degree, most: Self::MAX_DEGREE });
        }
        let control_points = knots.len().saturating_sub(degree + 1);
        if control_points <= degree {
            return Err(SplineError::TooFewControlPoints { degree, control_points });
        }
        if let Some((index, value)) = knots.iter().copied().enumerate().find(|(_, t)| !t.is_finite()) {
            return Err(SplineError::KnotNotFinite { index, value });
        }
        if let Some(i) = knots.windows(2).position(|pair| pair[1] < pair[0]) {
            return Err(SplineError::KnotsDecrease { index: i + 1, value: knots[i + 1], before: knots[i] });
        }
        for same in knots.chunk_by(|a, b| a == b) {
            if same.len() > degree + 1 {
                return Err(SplineError::KnotRepeated { value: same[0], count: same.len(), degree });
            }
        }
        if knots[degree] >= knots[control_points] {
            return Err(SplineError::EmptyDomain { at: knots[degree] });
        }
        Ok(Self { degree, knots })
    }

    /// Uniform knots on `[0, 1]`, the first and last repeated until the curve begins at its first control point and ends
    /// at its last.
    ///
    /// # Errors
    /// A degree too high, or not more control points than the degree.
    pub fn clamped(degree: usize, control_points: usize) -> Result<Self, SplineError> {
        let spans = Self::spans(degree, control_points)?;
        let inner = (0..=spans).map(|i| i as f64 / spans as f64);
        let knots = std::iter::repeat_n(0.0, degree).chain(inner).chain(std::iter::repeat_n(1.0, degree)).collect();
        Self::new(degree, knots)
    }

    /// Uniform knots through and through; the domain is `[0, 1]`. The curve passes through no control point in general.
    ///
    /// # Errors
    /// A degree too high, or not more control points than the degree.
    pub fn unclamped(degree: usize, control_points: usize) -> Result<Self, SplineError> {
        let spans = Self::spans(degree, control_points)? as f64;
        let knots = (0..control_points + degree + 1).map(|i| (i as f64 - degree as f64) / spans).collect();
        Self::new(degree, knots)
    }

    /// Spans of the domain where no knot is repeated.
    fn spans(degree: usize, control_points: usize) -> Result<usize, SplineError> {
        if degree > Self::MAX_DEGREE {
            return Err(SplineError::DegreeTooHigh { degree, most: Self::MAX_DEGREE });
        }
        if control_points <= degree {
            return Err(SplineError::TooFewControlPoints { degree, control_points });
        }
        Ok(control_points - degree)
    }

    /// Returns the degree of the polynomials.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Returns the knots, first to last.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// Returns the number of control points.
    pub fn control_points(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// Parameters at which the curve begins and ends: t_{k-1} and t_{n+1} of eq. 3.1.
    pub fn domain(&self) -> (f64, f64) {
        (self.knots[self.degree], self.knots[self.control_points()])
    }

    /// Returns the weight of every control point at `t`, or the `derivative`-th derivative of the weights by t. At a knot where the
    /// curve or its derivative jumps it is the value after it; at the end of the domain the one before.
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
        let (from, to) = self.domain();
        if !(from..=to).contains(&t) {
            return Err(SplineError::OutOfDomain { t, from, to });
        }
        let last = self.control_points();
        // At the end of the domain, step back over the knots that stand there.
        let after =
            if t < to { self.knots.partition_point(|k| *k <= t) } else { self.knots.partition_point(|k| *k < t) };
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

/// A [`BSpline`] as files have it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    degree: usize,
    knots: Vec<f64>,
}

impl TryFrom<Written> for BSpline {
    type Error = SplineError;

    fn try_from(written: Written) -> Result<Self, SplineError> {
        Self::new(written.degree, written.knots)
    }
}

impl From<BSpline> for Written {
    fn from(spline: BSpline) -> Self {
        Self { degree: spline.degree, knots: spline.knots }
    }
}
