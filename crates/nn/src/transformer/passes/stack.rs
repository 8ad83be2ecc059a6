//! Transformer blocks, forward and backward. Values that are cheap to compute again (normalized tokens, GELU) are not
//! kept.

use super::attention::{self, Shape, padded_bias};
use super::norm::Norm;
use crate::parameters::Parameters;
use crate::rows::gelu::gelu_and_gradient;
use crate::rows::{Linear, activated, add};
use crate::transformer::alibi;

/// Blocks, and one more normalization at the end.
#[derive(Debug, Clone)]
pub(super) struct Stack {
    blocks: Vec<Block>,
    norm: Norm,
    width: usize,
    heads: usize,
}

/// x + attention(norm(x)), then x + feed-forward(norm(x)): T5's order, in which nothing stands on the way from input to output but
/// additions. No map has a bias, as T5's have none.
///
/// T5 leaves out attention's factor 1/√(c/h) and draws the query weights smaller by it instead. At initialization that
/// is the same function. Here the factor stays, so that Adam's steps are not √(c/h) times as effective on queries as
/// on everything else.
#[derive(Debug, Clone)]
struct Block {
    norm_1: Norm,
    projection: Linear,
    output: Linear,
    norm_2: Norm,
    inner: Linear,
    outer: Linear,
}

/// Numbers that the backward pass of one block needs.
#[derive(Debug, Clone)]
struct BlockPass {
    x: Vec<f32>,
    projected: Vec<f32>,
    /// Attention's.
    weights: Vec<f32>,
    mixed: Vec<f32>,
    between: Vec<f32>,
    inner: Vec<f32>,
}

/// Numbers that the backward pass of a stack needs.
#[derive(Debug, Clone)]
pub(super) struct StackPass {
    blocks: Vec<BlockPass>,
    last: Vec<f32>,
    shape: Shape,
}

impl Stack {
    /// `layers` blocks that stand under `name`.
    pub(super) fn new(parameters: &Parameters, name: &str, layers: usize, width: usize, heads: usize) -> Self {
        let block = |i| Block::new(parameters, &format!("{name}.blocks.{i}"), width);
        Self {
            blocks: (0..layers).map(block).collect(),
            norm: Norm::new(parameters, &format!("{name}.norm")),
            width,
            heads,
        }
    }

    /// `x: [B, T, c]`, tokens at `positions`, to the same shape.
    pub(super) fn forward(&self, mut x: Vec<f32>, positions: &[f64]) -> (Vec<f32>, StackPass) {
        let shape = Shape { tokens: positions.len(), width: self.width, heads: self.heads };
        let bias = padded_bias(&alibi::bias(self.heads, positions), shape.tokens);
        let mut blocks = Vec::with_capacity(self.blocks.len());
        for block in &self.blocks {
            let (next, pass) = block.forward(x, &bias, shape);
            blocks.push(pass);
            x = next;
        }
        let out = self.norm.forward(&x);
        (out, StackPass { blocks, last: x, shape })
    }

    /// Adds the gradients of the stack's parameters; returns the gradient by `x`.
    pub(super) fn backward(&self, pass: StackPass, gradient: Vec<f32>, sums: &mut [f32]) -> Vec<f32> {
        let StackPass { blocks, last, shape } = pass;
        let mut by_x = vec![0.0; gradient.len()];
        self.norm.backward(&last, &gradient, &mut by_x, sums);
        for (block, pass) in self.blocks.iter().zip(blocks).rev() {
            by_x = block.backward(pass, shape, by_x, sums);
        }
        by_x
    }
}

impl Block {
    fn new(parameters: &Parameters, name: &str, width: usize) -> Self {
        let (layout, values) = (parameters.layout(), parameters.values());
        let map = |part: &str, inputs: usize| {
            let weight = format!("{name}.{part}");
            let outputs = layout.range(&weight).len() / inputs.max(1);
            Linear::without_bias(&weight, [inputs, outputs], layout, values)
        };
        let inner = map("feed_forward.inner", width);
        Self {
            norm_1: Norm::new(parameters, &format!("{name}.norm_1")),
            projection: map("attention.projection", width),
            output: map("attention.output", width),
            norm_2: Norm::new(parameters, &format!("{name}.norm_2")),
            outer: map("feed_forward.outer", inner.outputs()),
            inner,
        }
    }

    fn forward(&self, x: Vec<f32>, bias: &[f32], shape: Shape) -> (Vec<f32>, BlockPass) {
        let projected = self.projection.forward(&self.norm_1.forward(&x));
        let (mixed, weights) = attention::forward(&projected, bias, shape);
        let mut between = self.output.forward(&mixed);
        add(&mut between, &x);
        let inner = self.inner.forward(&self.norm_2.forward(&between));
        let mut out = self.outer.forward(&activated(&inner));
        add(&mut out, &between);
        (out, BlockPass { x, projected, weights, mixed, between, inner })
    }

    fn backward(&self, pass: BlockPass, shape: Shape, mut gradient: Vec<f32>, sums: &mut [f32]) -> Vec<f32> {
        let BlockPass { x, projected, weights, mixed, between, inner } = pass;

        let mut by_inner = self.outer.by_input(&gradient);
        let activated = through_gelu(&inner, &mut by_inner);
        self.outer.learn(&activated, &gradient, sums);
        let by_normed = self.inner.backward(&self.norm_2.forward(&between), &by_inner, sums);
        self.norm_2.backward(&between, &by_normed, &mut gradient, sums);

        let by_mixed = self.output.backward(&mixed, &gradient, sums);
        let by_projected = attention::backward(&projected, &weights, &by_mixed, shape);
        let by_normed = self.projection.backward(&self.norm_1.forward(&x), &by_projected, sums);
        self.norm_1.backward(&x, &by_normed, &mut gradient, sums);
        gradient
    }
}

/// Turns `gradient` into that below a GELU of `x`; returns the GELU as well.
pub(super) fn through_gelu(x: &[f32], gradient: &mut [f32]) -> Vec<f32> {
    let mut out = vec![0.0; x.len()];
    gelu_and_gradient(x, &mut out, gradient);
    out
}
