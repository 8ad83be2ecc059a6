//! Attention of all heads, and its gradient.
//!
//! Scores of a whole batch are tens of megabytes that a tensor library passes over a dozen times. Here all that is done to those of
//! one head of one sequence is done while they are in the cache. The weights that come out are kept for the way back: a batch goes
//! through in small parts, so they are a few megabytes. Dao et al. (2022) compute them again and spare that memory.

use lifelike_simd::vectorize;

use super::softmax::{softmax, through_softmax};
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

/// Memory for one head of one sequence.
#[derive(Default)]
struct Scratch {
    right: Vec<Lanes>,
    scores: Vec<f32>,
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

/// `projected: [B, T, 3c]` and `bias` of [`padded_bias`] to the heads' outputs `[B, T, c]` and the weights `[B, h, T, padded T]`.
pub(in crate::transformer) fn forward(projected: &[f32], bias: &[f32], shape: Shape) -> (Vec<f32>, Vec<f32>) {
    let Shape { tokens: t, width: c, .. } = shape;
    let batch = projected.len() / (t * 3 * c).max(1);
    let (mut out, mut scratch) = (vec![0.0; batch * t * c], Scratch::default());
    // Not filled before: it is the largest memory of all, and what is in the cache would leave it.
    let mut weights = Vec::with_capacity(batch * bias.len());
    vectorize(
        #[inline(always)]
        || {
            for (out, rows) in out.chunks_exact_mut(t * c).zip(projected.chunks_exact(t * 3 * c)) {
                for (head, bias) in bias.chunks_exact(t * padded(t)).enumerate() {
                    one_forward(&mut scratch, [rows, bias], shape, head, out);
                    weights.extend_from_slice(&scratch.scores);
                }
            }
        },
    );
    (out, weights)
}

/// Leaves the weights in `scratch.scores`.
#[inline(always)]
fn one_forward(scratch: &mut Scratch, [rows, bias]: [&[f32]; 2], shape: Shape, head: usize, mixed: &mut [f32]) {
    let Shape { tokens: t, width: c, heads } = shape;
    let (size, wide) = (c / heads, padded(t));
    let [queries, keys, values] = columns(shape, head);
    let scale = (size as f32).powf(-0.5);
    let Scratch { right, scores, out } = scratch;
    pack(right, size, t, View::columns(&rows[keys..], 3 * c), scale);
    scores.resize(t * wide, 0.0);
    product(scores, t, View::rows(&rows[queries..], 3 * c), right, size);
    softmax(scores, bias, wide);
    pack(right, t, size, View::rows(&rows[values..], 3 * c), 1.0);
    put(mixed, out, View::rows(scores, wide), right, shape, c, head * size);
}

/// Returns the gradient by `projected`, from the one by the outputs of [`forward`] and the weights that it returned.
pub(in crate::transformer) fn backward(projected: &[f32], weights: &[f32], by_mixed: &[f32], shape: Shape) -> Vec<f32> {
    let Shape { tokens: t, width: c, heads } = shape;
    let (mut out, mut scratch) = (vec![0.0; projected.len()], Scratch::default());
    let inputs = projected.chunks_exact(t * 3 * c).zip(by_mixed.chunks_exact(t * c));
    let inputs = inputs.zip(weights.chunks_exact(heads * t * padded(t)));
    vectorize(
        #[inline(always)]
        || {
            for (out, ((rows, by_mixed), weights)) in out.chunks_exact_mut(t * 3 * c).zip(inputs) {
                for (head, weights) in weights.chunks_exact(t * padded(t)).enumerate() {
                    one_backward(&mut scratch, [rows, weights, by_mixed], shape, head, out);
                }
            }
        },
    );
    out
}

#[inline(always)]
fn one_backward(
    scratch: &mut Scratch,
    [rows, weights, by_mixed]: [&[f32]; 3],
    shape: Shape,
    head: usize,
    out: &mut [f32],
) {
    let Shape { tokens: t, width: c, heads } = shape;
    let (size, wide) = (c / heads, padded(t));
    let [queries, keys, values] = columns(shape, head);
    let (own, scale) = (head * size, (size as f32).powf(-0.5));
    let Scratch { right, scores: gradients, out: part } = scratch;

    // By the weights: gradient · valuesᵀ.
    pack(right, size, t, View::columns(&rows[values..], 3 * c), 1.0);
    gradients.resize(t * wide, 0.0);
    product(gradients, t, View::rows(&by_mixed[own..], c), right, size);
    through_softmax(weights, gradients, wide);

    pack(right, t, size, View::rows(&by_mixed[own..], c), 1.0);
    put(out, part, View::columns(weights, wide), right, shape, 3 * c, values);
    pack(right, t, size, View::rows(&rows[keys..], 3 * c), scale);
    put(out, part, View::rows(gradients, wide), right, shape, 3 * c, queries);
    pack(right, t, size, View::rows(&rows[queries..], 3 * c), scale);
    put(out, part, View::columns(gradients, wide), right, shape, 3 * c, keys);
}

/// Writes left · right into one head's columns of `out`, whose rows begin every `stride` numbers, from `column` on.
#[inline(always)]
fn put(
    out: &mut [f32],
    part: &mut Vec<f32>,
    left: View<'_>,
    right: &[Lanes],
    shape: Shape,
    stride: usize,
    column: usize,
) {
    let (t, size) = (shape.tokens, shape.width / shape.heads);
    part.resize(t * padded(size), 0.0);
    product(part, t, left, right, t);
    for (out, part) in out.chunks_exact_mut(stride).zip(part.chunks_exact(padded(size))) {
        // Eight at a time: to copy an unknown number is a call that takes longer.
        let (eights, rest) = out[column..][..size].as_chunks_mut::<8>();
        let (from, last) = part[..size].as_chunks::<8>();
        eights.iter_mut().zip(from).for_each(|(out, part)| *out = *part);
        rest.iter_mut().zip(last).for_each(|(out, part)| *out = *part);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::collections::BTreeMap;

    use super::*;
    use crate::rows::{Layout, Linear};
    use crate::transformer::alibi;

    #[derive(serde::Deserialize)]
    struct Array {
        data: Vec<f32>,
    }

    /// PyTorch's, between the two maps that stand around it, with heads of a size that fills no vector.
    #[test]
    fn attention_with_linear_biases_is_pytorchs() {
        let text = include_str!("../../../tests/fixtures/transformer.json");
        let fixture: BTreeMap<String, Array> = serde_json::from_str(text).unwrap();
        for heads in [2, 3] {
            let (tokens, width) = (7, 4 * heads);
            let array = |part: &str| fixture[&format!("attention.{heads}.{part}")].data.clone();
            let close = |part: &str, got: &[f32]| {
                let expected = array(part);
                let scale = expected.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
                assert_eq!(got.len(), expected.len());
                assert!(got.iter().zip(&expected).all(|(a, b)| (a - b).abs() <= 1e-5 * scale), "{part}");
            };
            let layout = Layout::of_shapes(vec![
                ("projection".into(), vec![width, 3 * width]),
                ("output".into(), vec![width, width]),
            ]);
            let values = [array("projection"), array("output")].concat();
            let projection = Linear::without_bias("projection", [width, 3 * width], &layout, &values);
            let output = Linear::without_bias("output", [width, width], &layout, &values);

            let positions: Vec<f64> = (0..tokens).map(|i| i as f64).collect();
            let bias = padded_bias(&alibi::bias(heads, &positions), tokens);
            let shape = Shape { tokens, width, heads };
            let projected = projection.forward(&array("x"));
            let (mixed, weights) = forward(&projected, &bias, shape);
            close("y", &output.forward(&mixed));
            let mut sums = vec![0.0; layout.len()];
            let by_mixed = output.backward(&mixed, &array("dy"), &mut sums);
            let by_projected = backward(&projected, &weights, &by_mixed, shape);
            close("d.x", &projection.backward(&array("x"), &by_projected, &mut sums));
            close("d.projection", &sums[layout.range("projection")]);
            close("d.output", &sums[layout.range("output")]);
        }
    }
}
