//! Layers one after the other.

use super::layer::{Layer, LayerPass, NoBias};
use super::sizes::EncoderSizes;
use crate::rows::Layout;
use crate::transformer::passes::attention::padded_bias;

/// An encoder with its weights packed for one or many passes.
#[derive(Debug, Clone)]
pub struct Encoder {
    sizes: EncoderSizes,
    layers: Vec<Layer>,
}

/// Numbers that the backward pass needs.
#[derive(Debug, Clone)]
pub struct EncoderPass {
    layers: Vec<LayerPass>,
    lengths: Vec<usize>,
}

impl Encoder {
    /// Packs parameters that stand in `values` as `layout` says, named under `prefix`.
    pub fn new(sizes: EncoderSizes, layout: &Layout, prefix: &str, values: &[f32]) -> Self {
        let layer = |i: usize| Layer::new(&format!("{prefix}.{i}"), sizes, layout, values);
        Self { sizes, layers: (0..sizes.layers).map(layer).collect() }
    }

    /// Returns the tokens after all layers. Tokens see those of their own sequence.
    ///
    /// # Shapes
    /// `x: [sum of lengths, c]` to the same.
    pub fn forward(&self, mut x: Vec<f32>, lengths: &[usize]) -> (Vec<f32>, EncoderPass) {
        let zeros = |t: &usize| (*t, padded_bias(&vec![0.0; self.sizes.heads * t * t], *t));
        let no_bias: NoBias = lengths.iter().map(zeros).collect();
        let mut layers = Vec::with_capacity(self.layers.len());
        for layer in &self.layers {
            let (next, pass) = layer.forward(x, lengths, &no_bias);
            layers.push(pass);
            x = next;
        }
        (x, EncoderPass { layers, lengths: lengths.to_vec() })
    }

    /// Adds the gradients of the parameters to a row like theirs; returns the gradient by x.
    ///
    /// # Shapes
    /// `gradient: [sum of lengths, c]`, by what [`Self::forward`] returned, to the same.
    pub fn backward(&self, pass: EncoderPass, gradient: Vec<f32>, sums: &mut [f32]) -> Vec<f32> {
        let EncoderPass { layers, lengths } = pass;
        let all = self.layers.iter().zip(layers).rev();
        all.fold(gradient, |gradient, (layer, pass)| layer.backward(pass, &gradient, &lengths, sums))
    }
}
