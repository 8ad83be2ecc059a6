//! Curves as weighted sums of control points (thesis 3.2.1): which weights each sample gives to each control point.
//!
//! [`BSpline`] is the general case (eq. 3.1), [`CubicBezier`] the thesis' default (Algorithm 3), possibly of several
//! segments. [`Spline`] is either, on the parameter u in `[0, 1]`, and evaluates batches of control points as one matrix
//! product, so gradients pass through it.

mod bezier;
mod bspline;
mod curve;
mod error;

pub use bezier::{CubicBezier, Joints};
pub use bspline::BSpline;
pub use curve::{Spline, uniform};
pub use error::SplineError;
