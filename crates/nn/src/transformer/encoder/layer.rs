//! One layer: h = norm(x + attention(x)), norm(h + feed-forward(h)).

use std::collections::BTreeMap;

use super::sizes::{EncoderSizes, LINEAR, shapes};
use crate::rows::gelu::{activated, gelu_and_gradient};
use crate::rows::{Layout, PackedWeight, add, bias_gradient, layer_norm, weight_gradient};
use crate::transformer::backprop::attention::{self, Shape};

/// Biases that attention of each length takes: zeros, and what leaves no weight beyond the last token.
pub(super) type NoBias = BTreeMap<usize, Vec<f32>>;

/// A layer with its weights packed.
#[derive(Debug, Clone)]
pub(super) struct Layer {
    prefix: String,
    sizes: EncoderSizes,
    weights: [PackedWeight; 4],
    biases: [Vec<f32>; 4],
    /// Gain and bias of both norms.
    norms: [[Vec<f32>; 2]; 2],
}

/// Numbers that the backward pass needs.
#[derive(Debug, Clone)]
pub(super) struct LayerPass {
    x: Vec<f32>,
    projected: Vec<f32>,
    /// Attention's, of each sequence.
    attention: Vec<Vec<f32>>,
    mixed: Vec<f32>,
    /// Sums below the norms.
    sums: [Vec<f32>; 2],
    inner: Vec<f32>,
}

impl Layer {
    pub(super) fn new(prefix: String, sizes: EncoderSizes, layout: &Layout, values: &[f32]) -> Self {
        let numbers = |name: String| values[layout.range(&name)].to_vec();
        let shapes = shapes(sizes);
        Self {
            weights: std::array::from_fn(|i| {
                PackedWeight::new(&values[layout.range(&format!("{prefix}.{}.weight", LINEAR[i]))], shapes[i])
            }),
            biases: LINEAR.map(|name| numbers(format!("{prefix}.{name}.bias"))),
            norms: ["norm_1", "norm_2"].map(|n| ["gain", "bias"].map(|part| numbers(format!("{prefix}.{n}.{part}")))),
            prefix,
            sizes,
        }
    }

    pub(super) fn forward(&self, x: Vec<f32>, lengths: &[usize], no_bias: &NoBias) -> (Vec<f32>, LayerPass) {
        let linear = |i: usize, x: &[f32]| self.weights[i].forward(x, &self.biases[i]);
        let projected = linear(0, &x);
        let (mixed, attention) = self.attend(&projected, lengths, no_bias);
        let mut first = linear(1, &mixed);
        add(&mut first, &x);
        let h = self.norm(0, &first);
        let inner = linear(2, &h);
        let mut second = linear(3, &activated(&inner));
        add(&mut second, &h);
        let out = self.norm(1, &second);
        (out, LayerPass { x, projected, attention, mixed, sums: [first, second], inner })
    }

    /// Adds the gradients of the layer's parameters; returns the gradient by x.
    pub(super) fn backward(
        &self,
        pass: LayerPass,
        gradient: &[f32],
        lengths: &[usize],
        layout: &Layout,
        sums: &mut [f32],
    ) -> Vec<f32> {
        let LayerPass { x, projected, attention, mixed, sums: [first, second], inner } = pass;
        let mut by_second = self.through_norm(1, &second, gradient, layout, sums);
        let (mut by_inner, mut outer) = (self.weights[3].by_input(&by_second), vec![0.0; inner.len()]);
        gelu_and_gradient(&inner, &mut outer, &mut by_inner);
        self.learn(3, &outer, &by_second, layout, sums);
        let h = self.norm(0, &first);
        add(&mut by_second, &self.through(2, &h, &by_inner, layout, sums));
        let mut by_first = self.through_norm(0, &first, &by_second, layout, sums);
        let by_mixed = self.through(1, &mixed, &by_first, layout, sums);
        let by_projected = self.attend_back([&projected, &by_mixed], &attention, lengths);
        add(&mut by_first, &self.through(0, &x, &by_projected, layout, sums));
        by_first
    }

    fn norm(&self, i: usize, x: &[f32]) -> Vec<f32> {
        let [gain, bias] = &self.norms[i];
        layer_norm::forward(x, gain, bias)
    }

    fn through_norm(&self, i: usize, x: &[f32], gradient: &[f32], layout: &Layout, sums: &mut [f32]) -> Vec<f32> {
        // Gain and bias are neighbours.
        let range = layout.range(&format!("{}.norm_{}.gain", self.prefix, i + 1));
        let (by_gain, by_bias) = sums[range.start..range.end + range.len()].split_at_mut(range.len());
        layer_norm::backward(x, &self.norms[i][0], gradient, (by_gain, by_bias))
    }

    fn through(&self, i: usize, x: &[f32], gradient: &[f32], layout: &Layout, sums: &mut [f32]) -> Vec<f32> {
        self.learn(i, x, gradient, layout, sums);
        self.weights[i].by_input(gradient)
    }

    fn learn(&self, i: usize, x: &[f32], gradient: &[f32], layout: &Layout, sums: &mut [f32]) {
        let name = |part: &str| layout.range(&format!("{}.{}.{part}", self.prefix, LINEAR[i]));
        weight_gradient(x, gradient, shapes(self.sizes)[i], &mut sums[name("weight")]);
        bias_gradient(gradient, &mut sums[name("bias")]);
    }

    fn shape(&self, tokens: usize) -> Shape {
        Shape { tokens, width: self.sizes.width, heads: self.sizes.heads }
    }

    fn attend(&self, projected: &[f32], lengths: &[usize], no_bias: &NoBias) -> (Vec<f32>, Vec<Vec<f32>>) {
        let (mut out, mut weights) = (Vec::with_capacity(projected.len() / 3), Vec::with_capacity(lengths.len()));
        let (mut at, c) = (0, self.sizes.width);
        for t in lengths {
            let rows = &projected[at * 3 * c..(at + t) * 3 * c];
            let (mixed, own) = attention::forward(rows, &no_bias[t], self.shape(*t));
            out.extend(mixed);
            weights.push(own);
            at += t;
        }
        (out, weights)
    }

    fn attend_back(&self, [projected, by_mixed]: [&[f32]; 2], weights: &[Vec<f32>], lengths: &[usize]) -> Vec<f32> {
        let (mut out, mut at, c) = (Vec::with_capacity(projected.len()), 0, self.sizes.width);
        for (t, weights) in lengths.iter().zip(weights) {
            let rows = &projected[at * 3 * c..(at + t) * 3 * c];
            let by_mixed = &by_mixed[at * c..(at + t) * c];
            out.extend(attention::backward(rows, weights, by_mixed, self.shape(*t)));
            at += t;
        }
        out
    }
}
