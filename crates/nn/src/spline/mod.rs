//! Curves as weighted sums of control points (thesis 3.2.1): which weights each sample gives to each control point.
//!
//! [`CubicBezier`] is the thesis' curve (Algorithm 3) on the parameter u in `[0, 1]`. It evaluates batches of control points as
//! one matrix product, so gradients pass through it. [`BSpline`] has uniform knots (eq. 3.1).

mod bezier;
mod bspline;
mod error;

pub use bezier::{CubicBezier, uniform};
pub use bspline::BSpline;
pub use error::SplineError;
