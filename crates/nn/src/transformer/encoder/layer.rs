//! One layer: h = norm(x + attention(x)), norm(h + feed-forward(h)).

use std::collections::BTreeMap;
use std::ops::Range;

use super::sizes::{EncoderSizes, LINEAR, shapes};
use crate::rows::gelu::{activated, gelu_and_gradient};
use crate::rows::{Layout, Linear, add, layer_norm};
use crate::transformer::passes::attention::{self, Shape};

/// Biases that attention of each length takes: zeros, and what leaves no weight beyond the last token.
pub(super) type NoBias = BTreeMap<usize, Vec<f32>>;

/// A layer with its weights packed.
#[derive(Debug, Clone)]
pub(super) struct Layer {
    sizes: EncoderSizes,
    maps: [Linear; 4],
    norms: [Norm; 2],
}

/// Gain and bias of a norm, and where they stand in rows of gradients: they are neighbours.
#[derive(Debug, Clone)]
struct Norm {
    gain: Vec<f32>,
    bias: Vec<f32>,
    place: Range<usize>,
}

impl Norm {
    fn new(name: &str, layout: &Layout, values: &[f32]) -> Self {
        let [gain, bias] = ["gain", "bias"].map(|part| layout.range(&format!("{name}.{part}")));
        Self { place: gain.start..bias.end, gain: values[gain].to_vec(), bias: values[bias].to_vec() }
    }

    fn forward(&self, x: &[f32]) -> Vec<f32> {
        layer_norm::forward(x, &self.gain, &self.bias)
    }

    fn backward(&self, x: &[f32], gradient: &[f32], sums: &mut [f32]) -> Vec<f32> {
        let by = sums[self.place.clone()].split_at_mut(self.gain.len());
        layer_norm::backward(x, &self.gain, gradient, by)
    }
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
    pub(super) fn new(prefix: &str, sizes: EncoderSizes, layout: &Layout, values: &[f32]) -> Self {
        let shapes = shapes(sizes);
        Self {
            maps: std::array::from_fn(|i| Linear::new(&format!("{prefix}.{}", LINEAR[i]), shapes[i], layout, values)),
            norms: ["norm_1", "norm_2"].map(|name| Norm::new(&format!("{prefix}.{name}"), layout, values)),
            sizes,
        }
    }

    pub(super) fn forward(&self, x: Vec<f32>, lengths: &[usize], no_bias: &NoBias) -> (Vec<f32>, LayerPass) {
        let [projection, output, into, out_of] = &self.maps;
        let projected = projection.forward(&x);
        let (mixed, attention) = self.attend(&projected, lengths, no_bias);
        let mut first = output.forward(&mixed);
        add(&mut first, &x);
        let h = self.norms[0].forward(&first);
        let inner = into.forward(&h);
        let mut second = out_of.forward(&activated(&inner));
        add(&mut second, &h);
        let out = self.norms[1].forward(&second);
        (out, LayerPass { x, projected, attention, mixed, sums: [first, second], inner })
    }

    /// Adds the gradients of the layer's parameters; returns the gradient by x.
    pub(super) fn backward(&self, pass: LayerPass, gradient: &[f32], lengths: &[usize], sums: &mut [f32]) -> Vec<f32> {
        let LayerPass { x, projected, attention, mixed, sums: [first, second], inner } = pass;
        let [projection, output, into, out_of] = &self.maps;
        let mut by_second = self.norms[1].backward(&second, gradient, sums);
        let (mut by_inner, mut outer) = (out_of.by_input(&by_second), vec![0.0; inner.len()]);
        gelu_and_gradient(&inner, &mut outer, &mut by_inner);
        out_of.learn(&outer, &by_second, sums);
        let h = self.norms[0].forward(&first);
        add(&mut by_second, &into.backward(&h, &by_inner, sums));
        let mut by_first = self.norms[0].backward(&first, &by_second, sums);
        let by_mixed = output.backward(&mixed, &by_first, sums);
        let by_projected = self.attend_back([&projected, &by_mixed], &attention, lengths);
        add(&mut by_first, &projection.backward(&x, &by_projected, sums));
        by_first
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
