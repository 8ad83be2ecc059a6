//! Elementary functions of BERT.

use lifelike_dense::{layer_norm, product};
use lifelike_simd::vectorize;

/// A linear layer, weight `[inputs, outputs]`.
#[derive(Debug, Clone)]
pub(super) struct Linear {
    pub weight: Vec<f32>,
    pub bias: Vec<f32>,
}

impl Linear {
    /// Returns x W + b of rows, `[n, outputs]`.
    pub(super) fn apply(&self, rows: &[f32]) -> Vec<f32> {
        let outputs = self.bias.len();
        let inputs = self.weight.len() / outputs.max(1);
        let n = rows.len() / inputs.max(1);
        let mut out = vec![0.0; n * outputs];
        product(rows, &self.weight, [n, inputs, outputs], &mut out);
        add_to_rows(&mut out, &self.bias);
        out
    }
}

/// A layer normalisation with gain and bias.
#[derive(Debug, Clone)]
pub(super) struct Norm {
    pub gain: Vec<f32>,
    pub bias: Vec<f32>,
}

impl Norm {
    pub(super) fn apply(&self, rows: &mut [f32], epsilon: f32) {
        layer_norm(rows, &self.gain, epsilon);
        add_to_rows(rows, &self.bias);
    }
}

fn add_to_rows(rows: &mut [f32], bias: &[f32]) {
    vectorize(
        #[inline(always)]
        || {
            for row in rows.chunks_exact_mut(bias.len().max(1)) {
                row.iter_mut().zip(bias).for_each(|(x, b)| *x += b);
            }
        },
    );
}

/// Applies x Φ(x) with the error function (Abramowitz and Stegun 7.1.26, off by at most 1.5e-7), in place.
pub(super) fn gelu(numbers: &mut [f32]) {
    for x in numbers {
        let z = f64::from(*x) * std::f64::consts::FRAC_1_SQRT_2;
        *x = (0.5 * f64::from(*x) * (1.0 + erf(z))) as f32;
    }
}

fn erf(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.327_591_1 * x.abs());
    let polynomial =
        t * (0.254_829_592 + t * (-0.284_496_736 + t * (1.421_413_741 + t * (-1.453_152_027 + t * 1.061_405_429))));
    (1.0 - polynomial * (-x * x).exp()).copysign(x)
}

/// Normalises every row of `width` to exponentials of sum 1, in place.
pub(super) fn softmax(rows: &mut [f32], width: usize) {
    for row in rows.chunks_exact_mut(width.max(1)) {
        let most = row.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        row.iter_mut().for_each(|x| *x = (*x - most).exp());
        let sum: f32 = row.iter().sum();
        row.iter_mut().for_each(|x| *x /= sum);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_function_is_off_by_what_the_book_says() {
        // Abramowitz and Stegun, Table 7.1.
        for (x, expected) in [(0.0, 0.0), (0.5, 0.520_499_877_8), (1.0, 0.842_700_792_9), (2.0, 0.995_322_265_0)] {
            assert!((erf(x) - expected).abs() < 1.6e-7 && (erf(-x) + expected).abs() < 1.6e-7, "{x}");
        }
    }
}
