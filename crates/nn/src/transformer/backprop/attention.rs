//! Attention of all heads, and its gradient, without ever holding the scores of more than one head of one sequence.
//!
//! Scores of a whole batch are tens of megabytes that a tensor library passes over a dozen times. Here one head's stay in the
//! cache, and the backward pass computes them again from the rows' log-sums (Dao et al. 2022's idea, without tiles).

use super::softmax::softmax;
use super::threads::each_part;
use crate::rows::elementary::dot;
use crate::rows::tile::{Lanes, View, pack, padded, product};

/// Sizes of a batch.
#[derive(Debug, Clone, Copy)]
pub(in crate::transformer) struct Shape {
    /// T.
    pub(in crate::transformer) tokens: usize,
    /// c.
    pub(in crate::transformer) width: usize,
    /// h.
    pub(in crate::transformer) heads: usize,
}

/// Memory of one thread.
#[derive(Default)]
struct Scratch {
    right: Vec<Lanes>,
    scores: Vec<f32>,
    gradients: Vec<f32>,
    out: Vec<f32>,
}

/// Offsets of one head's numbers in a row of `projected`: queries, keys, values.
fn columns(shape: Shape, head: usize) -> [usize; 3] {
    let size = shape.width / shape.heads;
    [0, 1, 2].map(|part| part * shape.width + head * size)
}

/// Returns the bias, its rows filled up to whole panels with what leaves no weight.
pub(in crate::transformer) fn padded_bias(bias: &[f32], tokens: usize) -> Vec<f32> {
    let mut out = Vec::with_capacity(bias.len() / tokens.max(1) * padded(tokens));
    for row in bias.chunks_exact(tokens.max(1)) {
        out.extend_from_slice(row);
        out.resize(out.len() + padded(tokens) - tokens, -1e30);
    }
    out
}

/// `projected: [B, T, 3c]` and `bias` of [`padded_bias`] to the heads' outputs `[B, T, c]`.
pub(in crate::transformer) fn forward(projected: &[f32], bias: &[f32], shape: Shape) -> Vec<f32> {
    let Shape { tokens: t, width: c, heads } = shape;
    let (size, wide) = (c / heads, padded(t));
    let mut out = vec![0.0; projected.len() / 3];
    each_part(
        &mut out,
        t * c,
        #[inline(always)]
        |first, part| {
            let mut scratch = Scratch::default();
            for (out, rows) in part.chunks_exact_mut(t * c).zip(projected[first * t * 3 * c..].chunks_exact(t * 3 * c))
            {
                for head in 0..heads {
                    let bias = &bias[head * t * wide..][..t * wide];
                    let values = columns(shape, head)[2];
                    weigh(&mut scratch, rows, bias, shape, head);
                    pack(&mut scratch.right, t, size, View::rows(&rows[values..], 3 * c), 1.0);
                    scratch.out.resize(t * padded(size), 0.0);
                    let left = View::rows(&scratch.scores, wide);
                    product(&mut scratch.out, t, left, &scratch.right, t);
                    for (out, mixed) in out.chunks_exact_mut(c).zip(scratch.out.chunks_exact(padded(size))) {
                        out[head * size..][..size].copy_from_slice(&mixed[..size]);
                    }
                }
            }
        },
    );
    out
}

/// Softmax of the scores of one head of one sequence, into `scratch.scores`.
#[inline(always)]
fn weigh(scratch: &mut Scratch, rows: &[f32], bias: &[f32], shape: Shape, head: usize) {
    let Shape { tokens: t, width: c, heads } = shape;
    let (size, wide) = (c / heads, padded(t));
    let [queries, keys, _] = columns(shape, head);
    let scale = (size as f32).powf(-0.5);
    pack(&mut scratch.right, size, t, View::columns(&rows[keys..], 3 * c), scale);
    scratch.scores.resize(t * wide, 0.0);
    let left = View::rows(&rows[queries..], 3 * c);
    product(&mut scratch.scores, t, left, &scratch.right, size);
    softmax(&mut scratch.scores, bias, wide);
}

/// Returns the gradient by `projected`, from the one by what [`forward`] returned as `mixed`.
pub(in crate::transformer) fn backward(
    projected: &[f32],
    mixed: &[f32],
    by_mixed: &[f32],
    bias: &[f32],
    shape: Shape,
) -> Vec<f32> {
    let Shape { tokens: t, width: c, heads } = shape;
    let wide = padded(t);
    let mut out = vec![0.0; projected.len()];
    each_part(
        &mut out,
        t * 3 * c,
        #[inline(always)]
        |first, part| {
            let mut scratch = Scratch::default();
            for (i, out) in part.chunks_exact_mut(t * 3 * c).enumerate() {
                let sequence = first + i;
                let rows = &projected[sequence * t * 3 * c..][..t * 3 * c];
                let [mixed, by_mixed] = [mixed, by_mixed].map(|all| &all[sequence * t * c..][..t * c]);
                for head in 0..heads {
                    let bias = &bias[head * t * wide..][..t * wide];
                    one_head(&mut scratch, out, [rows, mixed, by_mixed, bias], shape, head);
                }
            }
        },
    );
    out
}

#[inline(always)]
fn one_head(
    scratch: &mut Scratch,
    out: &mut [f32],
    [rows, mixed, by_mixed, bias]: [&[f32]; 4],
    shape: Shape,
    head: usize,
) {
    let Shape { tokens: t, width: c, heads } = shape;
    let (size, wide) = (c / heads, padded(t));
    let [queries, keys, values] = columns(shape, head);
    let own = head * size;
    let scale = (size as f32).powf(-0.5);
    weigh(scratch, rows, bias, shape, head);
    let Scratch { right, scores, gradients, out: part } = scratch;
    part.resize(t * padded(size), 0.0);

    // By the weights: gradient · valuesᵀ; then through the softmax, w (g − Σ w g), where Σ w g = output · its gradient.
    pack(right, size, t, View::columns(&rows[values..], 3 * c), 1.0);
    gradients.resize(t * wide, 0.0);
    product(gradients, t, View::rows(&by_mixed[own..], c), right, size);
    let token_rows = mixed.chunks_exact(c).zip(by_mixed.chunks_exact(c));
    let weights = scores.chunks_exact(wide);
    for ((gradients, weights), (mixed, by_mixed)) in gradients.chunks_exact_mut(wide).zip(weights).zip(token_rows) {
        let along = dot(&mixed[own..][..size], &by_mixed[own..][..size]);
        for (gradient, weight) in gradients.iter_mut().zip(weights) {
            *gradient = weight * (*gradient - along);
        }
    }

    pack(right, t, size, View::rows(&by_mixed[own..], c), 1.0);
    put(out, part, View::columns(scores, wide), right, shape, values);
    pack(right, t, size, View::rows(&rows[keys..], 3 * c), scale);
    put(out, part, View::rows(gradients, wide), right, shape, queries);
    pack(right, t, size, View::rows(&rows[queries..], 3 * c), scale);
    put(out, part, View::columns(gradients, wide), right, shape, keys);
}

/// Writes left · right into one head's columns of `out`, from `column` on.
#[inline(always)]
fn put(out: &mut [f32], part: &mut [f32], left: View<'_>, right: &[Lanes], shape: Shape, column: usize) {
    let Shape { tokens: t, width: c, heads } = shape;
    let size = c / heads;
    product(part, t, left, right, t);
    for (out, part) in out.chunks_exact_mut(3 * c).zip(part.chunks_exact(padded(size))) {
        out[column..][..size].copy_from_slice(&part[..size]);
    }
}
