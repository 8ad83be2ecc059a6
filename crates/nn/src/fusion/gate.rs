//! A gated linear unit beside a skip connection, then layer normalization.

use std::ops::Range;

use lifelike_simd::vectorize;

use super::elementary::sigmoid;
use crate::rows::tile::{LANES, Lanes};
use crate::rows::{Entry, Init, Layout, Linear, layer_norm};

/// norm(skip + a ⊙ σ(b)) with [a, b] = x W + c (Lim et al. 2021, eqs. 2 and 5): the network can leave x out.
#[derive(Debug, Clone)]
pub struct GateAddNorm {
    linear: Linear,
    gain: Vec<f32>,
    bias: Vec<f32>,
    /// Range of gain and bias, one after the other.
    norm: Range<usize>,
}

/// Numbers that the way back needs.
#[derive(Debug, Clone)]
pub struct GatePass {
    x: Vec<f32>,
    both: Vec<f32>,
    sum: Vec<f32>,
}

impl GateAddNorm {
    /// Returns its parameters: `NAME.weight` `[inputs, 2 width]`, `NAME.bias`, `NAME.norm.gain` and `NAME.norm.bias`.
    pub fn entries(name: &str, inputs: usize, width: usize) -> Vec<Entry> {
        let mut out = Entry::linear(name, inputs, 2 * width).to_vec();
        for (part, value) in [("gain", 1.0), ("bias", 0.0)] {
            let init = Init::Constant(value);
            out.push(Entry { name: format!("{name}.norm.{part}"), shape: vec![width], init });
        }
        out
    }

    /// Packs parameters that stand as the layout says.
    pub fn new(name: &str, inputs: usize, width: usize, layout: &Layout, values: &[f32]) -> Self {
        let gain = layout.range(&format!("{name}.norm.gain"));
        let bias = layout.range(&format!("{name}.norm.bias"));
        Self {
            linear: Linear::new(name, [inputs, 2 * width], layout, values),
            gain: values[gain.clone()].to_vec(),
            bias: values[bias.clone()].to_vec(),
            norm: gain.start..bias.end,
        }
    }

    /// Goes forward.
    ///
    /// # Shapes
    /// `x: [rows, inputs]`, `skip: [rows, width]` to `[rows, width]`.
    pub fn forward(&self, x: Vec<f32>, skip: &[f32]) -> (Vec<f32>, GatePass) {
        let both = self.linear.forward(&x);
        let (mut sum, c) = (skip.to_vec(), self.gain.len());
        vectorize(
            #[inline(always)]
            || {
                for (sum, both) in sum.chunks_exact_mut(c).zip(both.chunks_exact(2 * c)) {
                    let (a, b) = both.split_at(c);
                    for ((sum, a), b) in sum.iter_mut().zip(a).zip(b) {
                        *sum += a * sigmoid(*b);
                    }
                }
            },
        );
        let out = layer_norm::forward(&sum, &self.gain, &self.bias);
        (out, GatePass { x, both, sum })
    }

    /// Goes forward with rows side by side; `skip` becomes what comes out.
    #[inline(always)]
    pub(super) fn side_by_side(&self, x: &[Lanes], skip: &mut [Lanes], both: &mut Vec<Lanes>) {
        let c = self.gain.len();
        both.resize(2 * c, [0.0; LANES]);
        self.linear.side_by_side(x, both);
        let (a, b) = both.split_at(c);
        for ((sum, a), b) in skip.iter_mut().zip(a).zip(b) {
            for ((sum, a), b) in sum.iter_mut().zip(a).zip(b) {
                *sum += a * sigmoid(*b);
            }
        }
        layer_norm::side_by_side(skip, &self.gain, &self.bias);
    }

    /// Adds the parameters' gradients; returns those by x and by the skip connection.
    pub fn backward(&self, pass: GatePass, gradient: &[f32], sums: &mut [f32]) -> (Vec<f32>, Vec<f32>) {
        let (GatePass { x, mut both, sum }, c) = (pass, self.gain.len());
        let (by_gain, by_bias) = sums[self.norm.clone()].split_at_mut(c);
        let by_sum = layer_norm::backward(&sum, &self.gain, gradient, (by_gain, by_bias));
        vectorize(
            #[inline(always)]
            || {
                for (both, by_sum) in both.chunks_exact_mut(2 * c).zip(by_sum.chunks_exact(c)) {
                    let (a, b) = both.split_at_mut(c);
                    for ((a, b), by_sum) in a.iter_mut().zip(b).zip(by_sum) {
                        let gate = sigmoid(*b);
                        *b = by_sum * *a * gate * (1.0 - gate);
                        *a = by_sum * gate;
                    }
                }
            },
        );
        (self.linear.backward(&x, &both, sums), by_sum)
    }
}
