//! Errors of splines.

/// A spline that cannot be, or a place where it is not.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SplineError {
    /// A curve of degree p needs p + 1 control points.
    #[error("spline: degree {degree} needs at least {} control points, got {control_points}", degree + 1)]
    TooFewControlPoints {
        /// Degree of the polynomials.
        degree: usize,
        /// The number found.
        control_points: usize,
    },
    /// Degrees above [`super::BSpline::MAX_DEGREE`] are refused: they are of no use, and their weights lose all digits.
    #[error("spline: expected a degree of at most {most}, got {degree}")]
    DegreeTooHigh {
        /// The value asked for.
        degree: usize,
        /// The highest that is taken.
        most: usize,
    },
    /// A knot is NaN or infinite.
    #[error("spline: knot {index} is {value}, expected a finite number")]
    KnotNotFinite {
        /// The knot, from 0.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A knot is smaller than the one before it.
    #[error("spline: knots must not decrease, but knot {index} is {value} after {before}")]
    KnotsDecrease {
        /// The knot, from 0.
        index: usize,
        /// Its value.
        value: f64,
        /// The knot before it.
        before: f64,
    },
    /// A knot stands more than degree + 1 times: some control point would have no effect anywhere.
    #[error("spline: knot {value} stands {count} times, at most {} fit degree {degree}", degree + 1)]
    KnotRepeated {
        /// The knot.
        value: f64,
        /// Its multiplicity.
        count: usize,
        /// Degree of the polynomials.
        degree: usize,
    },
    /// The curve's domain has no length.
    #[error("spline: the domain begins and ends at knot {at}")]
    EmptyDomain {
        /// The knot.
        at: f64,
    },
    /// A parameter outside of the domain, or NaN.
    #[error("spline: t = {t} is outside of the domain {from} to {to}")]
    OutOfDomain {
        /// The parameter.
        t: f64,
        /// Beginning of the domain.
        from: f64,
        /// End of the domain.
        to: f64,
    },
    /// A curve without segments.
    #[error("spline: expected at least one segment")]
    NoSegments,
    /// A tensor with another number of control points than the spline has.
    #[error("spline: expected {expected} control points, got {got}")]
    WrongControlPoints {
        /// Control points of the spline.
        expected: usize,
        /// Control points of the tensor.
        got: usize,
    },
}
