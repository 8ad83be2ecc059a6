//! Muon (Jordan et al. 2024): a weight matrix moves by its momentum made orthogonal.
//!
//! Most of a momentum matrix is in a few directions, and Adam's steps, number by number, hardly change that. Made orthogonal, it moves
//! the matrix as far in every direction. Only matrices between hidden numbers are moved so: those of transformer and residual blocks, where each
//! tap of a convolution is one. Embeddings, heads, gains and biases are Adam's.

use std::collections::BTreeMap;

use burn::tensor::Tensor;

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

/// Takes a gradient into the momentum, of the same shape; returns what is to be made orthogonal.
pub(crate) fn gathered(momentum: &mut Tensor<1>, gradient: Tensor<1>) -> Tensor<1> {
    let mix = |a: Tensor<1>, b: Tensor<1>| a.mul_scalar(MOMENTUM).add(b.mul_scalar(1.0 - MOMENTUM));
    *momentum = mix(momentum.clone(), gradient.clone());
    mix(momentum.clone(), gradient)
}

/// Returns the steps of matrices for a learning rate of 1, from what [`gathered`] returned, all flattened, by name.
///
/// Matrices of one size go through the products together, which have work for every core then.
pub(crate) fn steps(matrices: Vec<(String, [usize; 2], Tensor<1>)>) -> BTreeMap<String, Tensor<1>> {
    let mut alike: BTreeMap<[usize; 2], Vec<(String, Tensor<2>)>> = BTreeMap::new();
    for (name, shape, numbers) in matrices {
        alike.entry(shape).or_default().push((name, numbers.reshape(shape)));
    }
    let mut steps = BTreeMap::new();
    for ([rows, columns], named) in alike {
        let (names, matrices): (Vec<String>, Vec<Tensor<2>>) = named.into_iter().unzip();
        let size = SIZE * (rows.max(columns) as f64).sqrt();
        let all = orthogonal(Tensor::stack(matrices, 0)).mul_scalar(size);
        for (i, name) in names.into_iter().enumerate() {
            steps.insert(name, all.clone().narrow(0, i, 1).reshape([rows * columns]));
        }
    }
    steps
}

/// Returns U Vᵀ of each matrix U S Vᵀ, nearly: singular values between 0.7 and 1.2 (Newton and Schulz's iteration).
///
/// # Shapes
/// `[N, rows, columns]` to the same.
fn orthogonal(matrices: Tensor<3>) -> Tensor<3> {
    let [_, rows, columns] = matrices.dims();
    if rows > columns {
        return orthogonal(matrices.swap_dims(1, 2)).swap_dims(1, 2);
    }
    let norm = matrices.clone().square().sum_dim(2).sum_dim(1).sqrt().clamp_min(EPSILON);
    let mut x = matrices.div(norm);
    let [a, b, c] = QUINTIC;
    for _ in 0..TURNS {
        let square = x.clone().matmul(x.clone().swap_dims(1, 2));
        let even = square.clone().mul_scalar(b).add(square.clone().matmul(square).mul_scalar(c));
        x = x.clone().mul_scalar(a).add(even.matmul(x));
    }
    x
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use burn::tensor::TensorData;

    #[test]
    fn what_comes_out_is_nearly_orthogonal_and_turns_with_what_went_in() {
        let device = crate::device::inference();
        for [rows, columns] in [[6, 6], [4, 9], [9, 4]] {
            let number = |i: usize| ((i * 37 + i * i * 11) % 101) as f32 * 0.013 - 0.6;
            let numbers: Vec<f32> = (0..2 * rows * columns).map(number).collect();
            let matrices = Tensor::<3>::from_data(TensorData::new(numbers, [2, rows, columns]), &device);
            let out = orthogonal(matrices.clone());
            let short = |x: Tensor<3>| if rows <= columns { x } else { x.swap_dims(1, 2) };
            let (out, matrices) = (short(out), short(matrices));
            let count = rows.min(columns);
            let gram: Vec<f32> = out.clone().matmul(out.clone().swap_dims(1, 2)).try_to_vec_as().unwrap();
            // The singular values' squares add up to the trace.
            let trace: f32 = (0..2 * count).map(|i| gram[i / count * count * count + i % count * (count + 1)]).sum();
            assert!((trace / (2 * count) as f32 - 0.9).abs() < 0.35, "{rows}x{columns}: {trace}");
            // U Vᵀ (U S Vᵀ)ᵀ = U S Uᵀ is symmetric.
            let along: Vec<f32> = out.matmul(matrices.swap_dims(1, 2)).try_to_vec_as().unwrap();
            for n in 0..2 {
                for i in 0..count {
                    for j in 0..count {
                        let at = |i: usize, j: usize| along[n * count * count + i * count + j];
                        assert!((at(i, j) - at(j, i)).abs() < 1e-4, "{rows}x{columns}: {} {}", at(i, j), at(j, i));
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
