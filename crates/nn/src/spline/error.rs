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
    /// A parameter outside of the domain, or NaN.
    #[error("spline: t = {t} is outside of the domain 0 to 1")]
    OutOfDomain {
        /// The parameter.
        t: f64,
    },
    /// A file with another curve.
    #[error("spline: expected one segment with joints 'separate', got {segments} with '{joints}'")]
    OtherCurve {
        /// Its segments.
        segments: usize,
        /// Relation of neighbouring segments.
        joints: String,
    },
    /// A tensor with another number of control points than the spline has.
    #[error("spline: expected {expected} control points, got {got}")]
    WrongControlPoints {
        /// Control points of the spline.
        expected: usize,
        /// Control points of the tensor.
        got: usize,
    },
}
