//! Layer normalization (Ba et al. 2016) with gain and bias, and its gradient.

use lifelike_simd::vectorize;

use super::tile::{LANES, Lanes};

/// PyTorch's default.
const EPSILON: f32 = 1e-5;

/// Σ term(i), in lanes.
#[inline(always)]
fn sum(count: usize, term: impl Fn(usize) -> f32) -> f32 {
    let mut sums = [0.0_f32; LANES];
    let whole = count / LANES * LANES;
    for first in (0..whole).step_by(LANES) {
        for (lane, sum) in sums.iter_mut().enumerate() {
            *sum += term(first + lane);
        }
    }
    sums.iter().sum::<f32>() + (whole..count).map(term).sum::<f32>()
}

/// Mean and 1 / standard deviation.
#[inline(always)]
fn moments(x: &[f32]) -> (f32, f32) {
    let n = x.len() as f32;
    let mean = sum(x.len(), |i| x[i]) / n;
    let variance = sum(x.len(), |i| (x[i] - mean) * (x[i] - mean)) / n;
    (mean, 1.0 / (variance + EPSILON).sqrt())
}

/// Every row to mean 0 and variance 1, times gain plus bias.
pub(crate) fn forward(x: &[f32], gain: &[f32], bias: &[f32]) -> Vec<f32> {
    let mut out = vec![0.0; x.len()];
    vectorize(
        #[inline(always)]
        || {
            for (out, x) in out.chunks_exact_mut(gain.len()).zip(x.chunks_exact(gain.len())) {
                let (mean, inverse) = moments(x);
                for (((out, x), gain), bias) in out.iter_mut().zip(x).zip(gain).zip(bias) {
                    *out = (x - mean) * inverse * gain + bias;
                }
            }
        },
    );
    out
}

/// The same for rows side by side, in place.
#[inline(always)]
pub(crate) fn side_by_side(x: &mut [Lanes], gain: &[f32], bias: &[f32]) {
    let n = x.len() as f32;
    let (mut mean, mut inverse) = ([0.0_f32; LANES], [0.0_f32; LANES]);
    for x in &*x {
        for (mean, x) in mean.iter_mut().zip(x) {
            *mean += x / n;
        }
    }
    for x in &*x {
        for ((inverse, mean), x) in inverse.iter_mut().zip(&mean).zip(x) {
            *inverse += (x - mean) * (x - mean) / n;
        }
    }
    for x in &mut inverse {
        *x = 1.0 / (*x + EPSILON).sqrt();
    }
    for ((x, gain), bias) in x.iter_mut().zip(gain).zip(bias) {
        for ((x, mean), inverse) in x.iter_mut().zip(&mean).zip(&inverse) {
            *x = (*x - mean) * inverse * gain + bias;
        }
    }
}

/// Returns the gradient by x, from the one by the output; adds those by gain and bias.
pub(crate) fn backward(x: &[f32], gain: &[f32], gradient: &[f32], by: (&mut [f32], &mut [f32])) -> Vec<f32> {
    let c = gain.len();
    let mut out = vec![0.0; x.len()];
    let mut scaled = vec![0.0_f32; c];
    let mut normal = vec![0.0_f32; c];
    vectorize(
        #[inline(always)]
        || {
            let rows = x.chunks_exact(c).zip(gradient.chunks_exact(c));
            for (out, (x, dy)) in out.chunks_exact_mut(c).zip(rows) {
                let (mean, inverse) = moments(x);
                for i in 0..c {
                    normal[i] = (x[i] - mean) * inverse;
                    scaled[i] = dy[i] * gain[i];
                    by.0[i] += dy[i] * normal[i];
                    by.1[i] += dy[i];
                }
                let (scaled, normal) = (&scaled[..c], &normal[..c]);
                let level = sum(c, |i| scaled[i]) / c as f32;
                let along = sum(c, |i| scaled[i] * normal[i]) / c as f32;
                for i in 0..c {
                    out[i] = inverse * (scaled[i] - level - normal[i] * along);
                }
            }
        },
    );
    out
}
