//! A [`Stack`] of blocks, forward and backward. What is cheap to compute again (normalized tokens, GELU) is not kept.

use rayon::prelude::*;

use super::attention::{self, Shape, padded_bias};
use super::linear::{by_input, learn, multiply, numbers, put, through};
use super::threads::WORTHWHILE;
use super::{Grads, norm};
use crate::numbers::Unreadable;
use crate::rows::add;
use crate::rows::gelu::{gelu, gelu_and_gradient};
use crate::transformer::alibi;
use crate::transformer::block::{Block, Stack};

/// Numbers that the backward pass of one block needs.
#[derive(Debug, Clone)]
struct BlockPass {
    x: Vec<f32>,
    projected: Vec<f32>,
    mixed: Vec<f32>,
    between: Vec<f32>,
    inner: Vec<f32>,
}

/// Numbers that the backward pass of a stack needs.
#[derive(Debug, Clone)]
pub(super) struct StackPass {
    blocks: Vec<BlockPass>,
    last: Vec<f32>,
    bias: Vec<f32>,
    shape: Shape,
}

/// `x: [B, T, c]`, tokens at `positions`, to the same shape.
pub(super) fn forward(
    stack: &Stack,
    mut x: Vec<f32>,
    positions: &[f64],
    heads: usize,
) -> Result<(Vec<f32>, StackPass), Unreadable> {
    let shape = Shape { tokens: positions.len(), width: stack.norm.gain.dims()[0], heads };
    let bias = padded_bias(&alibi::bias(heads, positions), shape.tokens);
    let mut blocks = Vec::with_capacity(stack.blocks.len());
    for block in &stack.blocks {
        let (next, pass) = block_forward(block, x, &bias, shape)?;
        blocks.push(pass);
        x = next;
    }
    let out = norm::forward(&x, &numbers(&stack.norm.gain)?);
    Ok((out, StackPass { blocks, last: x, bias, shape }))
}

fn block_forward(block: &Block, x: Vec<f32>, bias: &[f32], shape: Shape) -> Result<(Vec<f32>, BlockPass), Unreadable> {
    let normed = norm::forward(&x, &numbers(&block.norm_1.gain)?);
    let projected = multiply(&normed, &block.attention.projection)?;
    let mixed = attention::forward(&projected, bias, shape);
    let mut between = multiply(&mixed, &block.attention.output)?;
    add(&mut between, &x);
    let normed = norm::forward(&between, &numbers(&block.norm_2.gain)?);
    let inner = multiply(&normed, &block.feed_forward.inner)?;
    let mut out = multiply(&activated(&inner), &block.feed_forward.outer)?;
    add(&mut out, &between);
    Ok((out, BlockPass { x, projected, mixed, between, inner }))
}

/// Puts the gradients of the stack's parameters, named under `prefix`; returns the gradient by `x`.
pub(super) fn backward(
    stack: &Stack,
    pass: StackPass,
    gradient: Vec<f32>,
    prefix: &str,
    grads: &mut Grads,
) -> Result<Vec<f32>, Unreadable> {
    let StackPass { blocks, last, bias, shape } = pass;
    let mut by_x = vec![0.0; gradient.len()];
    let by_gain = norm::backward(&last, &numbers(&stack.norm.gain)?, &gradient, &mut by_x);
    put(&stack.norm.gain, by_gain, format!("{prefix}.norm.gain"), grads);
    for ((i, block), pass) in stack.blocks.iter().enumerate().zip(blocks).rev() {
        by_x = block_backward(block, pass, &bias, shape, by_x, &format!("{prefix}.blocks.{i}"), grads)?;
    }
    Ok(by_x)
}

fn block_backward(
    block: &Block,
    pass: BlockPass,
    bias: &[f32],
    shape: Shape,
    mut gradient: Vec<f32>,
    prefix: &str,
    grads: &mut Grads,
) -> Result<Vec<f32>, Unreadable> {
    let BlockPass { x, projected, mixed, between, inner } = pass;
    let name = |part: &str| format!("{prefix}.{part}");

    let gain = numbers(&block.norm_2.gain)?;
    let weight = &block.feed_forward.outer;
    let mut by_inner = by_input(weight, &gradient)?;
    let activated = through_gelu(&inner, &mut by_inner);
    learn(&activated, weight, &gradient, name("feed_forward.outer"), grads);
    let normed = norm::forward(&between, &gain);
    let by_normed = through(&normed, &block.feed_forward.inner, &by_inner, name("feed_forward.inner"), grads)?;
    let by_gain = norm::backward(&between, &gain, &by_normed, &mut gradient);
    put(&block.norm_2.gain, by_gain, name("norm_2.gain"), grads);

    let gain = numbers(&block.norm_1.gain)?;
    let weight = &block.attention.output;
    let by_mixed = through(&mixed, weight, &gradient, name("attention.output"), grads)?;
    let by_projected = attention::backward(&projected, &mixed, &by_mixed, bias, shape);
    let normed = norm::forward(&x, &gain);
    let weight = &block.attention.projection;
    let by_normed = through(&normed, weight, &by_projected, name("attention.projection"), grads)?;
    let by_gain = norm::backward(&x, &gain, &by_normed, &mut gradient);
    put(&block.norm_1.gain, by_gain, name("norm_1.gain"), grads);
    Ok(gradient)
}

/// GELU of each number.
pub(super) fn activated(x: &[f32]) -> Vec<f32> {
    let mut out = vec![0.0; x.len()];
    let parts = out.par_chunks_mut(WORTHWHILE).zip(x.par_chunks(WORTHWHILE));
    parts.for_each(|(out, x)| gelu(x, out));
    out
}

/// Turns `gradient` into that below a GELU of `x`; returns the GELU as well.
pub(super) fn through_gelu(x: &[f32], gradient: &mut [f32]) -> Vec<f32> {
    let mut out = vec![0.0; x.len()];
    let parts = out.par_chunks_mut(WORTHWHILE).zip(x.par_chunks(WORTHWHILE));
    let parts = parts.zip(gradient.par_chunks_mut(WORTHWHILE));
    parts.for_each(|((out, x), gradient)| gelu_and_gradient(x, out, gradient));
    out
}
