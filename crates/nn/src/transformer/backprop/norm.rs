//! [`super::super::RmsNorm`] and its gradient.

use lifelike_simd::vectorize;

use super::threads::each_part;
use crate::rows::elementary::dot;
use crate::transformer::norm::EPSILON;

/// 1 / root of the mean square.
#[inline(always)]
fn inverse_root(x: &[f32]) -> f32 {
    1.0 / (dot(x, x) / x.len() as f32 + EPSILON as f32).sqrt()
}

/// x / root · gain, for every row.
pub(super) fn forward(x: &[f32], gain: &[f32]) -> Vec<f32> {
    let c = gain.len();
    let mut out = vec![0.0; x.len()];
    each_part(
        &mut out,
        c,
        #[inline(always)]
        |first, part| {
            for (out, x) in part.chunks_exact_mut(c).zip(x[first * c..].chunks_exact(c)) {
                let r = inverse_root(x);
                for ((out, x), gain) in out.iter_mut().zip(x).zip(gain) {
                    *out = x * r * gain;
                }
            }
        },
    );
    out
}

/// Adds to `gradient` (by the sum that x stands in) what comes through the normalization; returns the gain's gradient.
pub(super) fn backward(x: &[f32], gain: &[f32], by_output: &[f32], gradient: &mut [f32]) -> Vec<f32> {
    let c = gain.len();
    each_part(
        gradient,
        c,
        #[inline(always)]
        |first, part| {
            let mut scaled = vec![0.0; c];
            let rows = x[first * c..].chunks_exact(c).zip(by_output[first * c..].chunks_exact(c));
            for (gradient, (x, dy)) in part.chunks_exact_mut(c).zip(rows) {
                let r = inverse_root(x);
                for ((scaled, dy), gain) in scaled.iter_mut().zip(dy).zip(gain) {
                    *scaled = dy * gain;
                }
                let along = r * r * dot(&scaled, x) / c as f32;
                for ((gradient, x), scaled) in gradient.iter_mut().zip(x).zip(&scaled) {
                    *gradient += r * (scaled - x * along);
                }
            }
        },
    );
    let mut by_gain = vec![0.0_f32; c];
    vectorize(
        #[inline(always)]
        || {
            for (x, dy) in x.chunks_exact(c).zip(by_output.chunks_exact(c)) {
                let r = inverse_root(x);
                for ((sum, x), dy) in by_gain.iter_mut().zip(x).zip(dy) {
                    *sum += dy * x * r;
                }
            }
        },
    );
    by_gain
}
