//! T5's layer normalization: each token by the root of its mean square, times a gain. No mean is subtracted and
//! nothing added (Zhang & Sennrich 2019, as in T5, Raffel et al. 2020). And its gradient.

use std::ops::Range;

use lifelike_simd::vectorize;

use crate::parameters::Parameters;
use crate::rows::elementary::dot;

/// T5's.
const EPSILON: f32 = 1e-6;

/// 1 / root of the mean square.
#[inline(always)]
fn inverse_root(x: &[f32]) -> f32 {
    1.0 / (dot(x, x) / x.len() as f32 + EPSILON).sqrt()
}

/// A normalization with its gain.
#[derive(Debug, Clone)]
pub(super) struct Norm {
    gain: Vec<f32>,
    place: Range<usize>,
}

impl Norm {
    pub(super) fn new(parameters: &Parameters, name: &str) -> Self {
        let place = parameters.range(&format!("{name}.gain"));
        Self { gain: parameters.values()[place.clone()].to_vec(), place }
    }

    /// x / root · gain, for every row.
    pub(super) fn forward(&self, x: &[f32]) -> Vec<f32> {
        forward(x, &self.gain)
    }

    /// Adds to `gradient` (by the sum that x stands in) what comes through the normalization, and to `sums` the gain's gradient.
    pub(super) fn backward(&self, x: &[f32], by_output: &[f32], gradient: &mut [f32], sums: &mut [f32]) {
        through(x, &self.gain, by_output, gradient);
        by_gain(x, by_output, &mut sums[self.place.clone()]);
    }
}

fn forward(x: &[f32], gain: &[f32]) -> Vec<f32> {
    let c = gain.len();
    let mut out = vec![0.0; x.len()];
    vectorize(
        #[inline(always)]
        || {
            for (out, x) in out.chunks_exact_mut(c).zip(x.chunks_exact(c)) {
                let r = inverse_root(x);
                for ((out, x), gain) in out.iter_mut().zip(x).zip(gain) {
                    *out = x * r * gain;
                }
            }
        },
    );
    out
}

fn through(x: &[f32], gain: &[f32], by_output: &[f32], gradient: &mut [f32]) {
    let c = gain.len();
    let mut scaled = vec![0.0; c];
    vectorize(
        #[inline(always)]
        || {
            let rows = x.chunks_exact(c).zip(by_output.chunks_exact(c));
            for (gradient, (x, dy)) in gradient.chunks_exact_mut(c).zip(rows) {
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
}

fn by_gain(x: &[f32], by_output: &[f32], sum: &mut [f32]) {
    let c = sum.len();
    vectorize(
        #[inline(always)]
        || {
            for (x, dy) in x.chunks_exact(c).zip(by_output.chunks_exact(c)) {
                let r = inverse_root(x);
                for ((sum, x), dy) in sum.iter_mut().zip(x).zip(dy) {
                    *sum += dy * x * r;
                }
            }
        },
    );
}
