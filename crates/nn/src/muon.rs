//! Muon (Jordan et al. 2024): a weight matrix moves by its momentum made orthogonal.
//!
//! Most of a momentum matrix is in a few directions, and Adam's steps, number by number, hardly change that. Made orthogonal, it moves
//! the matrix as far in every direction. Only matrices between hidden numbers are moved so: those of transformer and residual blocks, where each
//! tap of a convolution is one. Embeddings, heads, gains and biases are Adam's.

use std::ops::Range;

use rayon::prelude::*;

use crate::rows::PackedWeight;

/// Share of the momentum that stays (Jordan et al.), by Nesterov's rule.
const MOMENTUM: f64 = 0.95;
/// Coefficients of the iteration, which pull singular values from 0 to 1 to about 1 in five turns instead of exactly there in more.
const QUINTIC: [f64; 3] = [3.4445, -4.7750, 2.0315];
const TURNS: usize = 5;
/// The least norm that a matrix is divided by at first.
const EPSILON: f64 = 1e-7;
/// Root mean square of a step's numbers by the learning rate, that of Adam's usual steps: so that a rate of Adam's serves (Liu et al. 2025).
const SIZE: f64 = 0.2;

/// Returns rows and columns of a parameter that is Muon's: a matrix of a block.
///
/// Queries, keys and values are one matrix here. As three they were compared and learn no better.
pub(crate) fn matrix(name: &str, shape: &[usize]) -> Option<[usize; 2]> {
    let shape = <[usize; 2]>::try_from(shape).ok()?;
    name.split('.').any(|part| part.ends_with("blocks")).then_some(shape)
}

/// Takes a gradient times `scale` into the momentum; returns what is to be made orthogonal.
pub(crate) fn gathered(momentum: &mut [f32], gradient: &[f32], scale: f32) -> Vec<f32> {
    let [keep, take] = [MOMENTUM as f32, (1.0 - MOMENTUM) as f32];
    let mut gathered = Vec::with_capacity(gradient.len());
    for (momentum, gradient) in momentum.iter_mut().zip(gradient) {
        let gradient = gradient * scale;
        *momentum = *momentum * keep + gradient * take;
        gathered.push(*momentum * keep + gradient * take);
    }
    gathered
}

/// Returns the steps of matrices for a learning rate of 1, from what [`gathered`] returned, each with its place. A core for each.
pub(crate) fn steps(matrices: Vec<(Range<usize>, [usize; 2], Vec<f32>)>) -> Vec<(Range<usize>, Vec<f32>)> {
    let step = |(range, [rows, columns], matrix): (Range<usize>, [usize; 2], Vec<f32>)| {
        let size = (SIZE * (rows.max(columns) as f64).sqrt()) as f32;
        let mut step = orthogonal(&matrix, [rows, columns]);
        step.iter_mut().for_each(|x| *x *= size);
        (range, step)
    };
    matrices.into_par_iter().map(step).collect()
}

/// Returns U Vᵀ of a matrix U S Vᵀ, nearly: singular values between 0.7 and 1.2 (Newton and Schulz's iteration).
///
/// # Shapes
/// `[rows, columns]` to the same.
fn orthogonal(matrix: &[f32], [rows, columns]: [usize; 2]) -> Vec<f32> {
    if rows > columns {
        let turned = orthogonal(&transposed(matrix, [rows, columns]), [columns, rows]);
        return transposed(&turned, [columns, rows]);
    }
    let norm = matrix.iter().map(|x| x * x).sum::<f32>().sqrt().max(EPSILON as f32);
    let mut x: Vec<f32> = matrix.iter().map(|x| x / norm).collect();
    let [a, b, c] = QUINTIC.map(|c| c as f32);
    for _ in 0..TURNS {
        let square = PackedWeight::new(&transposed(&x, [rows, columns]), [columns, rows]).forward(&x, &[]);
        let fourth = PackedWeight::new(&square, [rows, rows]).forward(&square, &[]);
        let even: Vec<f32> = square.iter().zip(&fourth).map(|(square, fourth)| square * b + fourth * c).collect();
        let moved = PackedWeight::new(&x, [rows, columns]).forward(&even, &[]);
        x.iter_mut().zip(moved).for_each(|(x, moved)| *x = *x * a + moved);
    }
    x
}

fn transposed(matrix: &[f32], [rows, columns]: [usize; 2]) -> Vec<f32> {
    (0..rows * columns).map(|i| matrix[i % rows * columns + i / rows]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// a bᵀ of `count` rows of each.
    fn products(a: &[f32], b: &[f32], [count, length]: [usize; 2]) -> Vec<f32> {
        let dot = |i: usize, j: usize| (0..length).map(|k| a[i * length + k] * b[j * length + k]).sum();
        (0..count * count).map(|at| dot(at / count, at % count)).collect()
    }

    #[test]
    fn the_result_is_nearly_orthogonal_and_turns_with_the_matrix() {
        for [rows, columns] in [[6, 6], [4, 9], [9, 4]] {
            for seed in [0, 40] {
                let number = |i: usize| ((i * 37 + i * i * 11) % 101) as f32 * 0.013 - 0.6;
                let matrix: Vec<f32> = (seed..seed + rows * columns).map(number).collect();
                let out = orthogonal(&matrix, [rows, columns]);
                let short = |x: &[f32]| if rows <= columns { x.to_vec() } else { transposed(x, [rows, columns]) };
                let (out, matrix) = (short(&out), short(&matrix));
                let (count, length) = (rows.min(columns), rows.max(columns));
                // The singular values' squares add up to the trace.
                let gram = products(&out, &out, [count, length]);
                let trace: f32 = (0..count).map(|i| gram[i * (count + 1)]).sum();
                assert!((trace / count as f32 - 0.9).abs() < 0.35, "{rows}x{columns}: {trace}");
                // U Vᵀ (U S Vᵀ)ᵀ = U S Uᵀ is symmetric.
                let along = products(&out, &matrix, [count, length]);
                for i in 0..count {
                    for j in 0..count {
                        let [one, other] = [along[i * count + j], along[j * count + i]];
                        assert!((one - other).abs() < 1e-4, "{rows}x{columns}: {one} {other}");
                    }
                }
            }
        }
    }

    #[test]
    fn only_matrices_of_blocks_are_moved() {
        assert_eq!(matrix("encoder.blocks.0.attention.projection", &[64, 192]), Some([64, 192]));
        assert_eq!(matrix("decoder_blocks.3.conv_1.weight_0", &[48, 48]), Some([48, 48]));
        assert_eq!(matrix("encoder.blocks.0.norm_1.gain", &[64]), None);
        assert_eq!((matrix("to_latent.weight", &[64, 16]), matrix("control", &[4, 64])), (None, None));
        assert_eq!((matrix("encoder_in.weight", &[260, 48]), matrix("encoder_out.weight", &[768, 128])), (None, None));
    }
}
