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

/// Normalises every row of `width` to exponentials of sum 1, in place.
pub(super) fn softmax(rows: &mut [f32], width: usize) {
    rows.chunks_exact_mut(width.max(1)).for_each(lifelike_nn::losses::softmax);
}
