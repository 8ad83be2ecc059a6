//! Products with weights, and their gradients: the tensor library's own, on all cores.

use burn::module::Param;
use burn::tensor::{Tensor, TensorData};
use lifelike_simd::vectorize;

use super::Grads;
use crate::numbers::{Unreadable, read};
use crate::transformer::heads::Affine;

/// x · weight, and x itself, which is only lent.
pub(super) fn multiply(x: Vec<f32>, weight: &Param<Tensor<2>>) -> Result<(Vec<f32>, Vec<f32>), Unreadable> {
    let weight = weight.val().without_autodiff();
    let x = tensor(x, &weight, weight.dims()[0]);
    Ok((read(x.clone().matmul(weight))?, read(x)?))
}

/// Puts the gradient of a weight that [`multiply`] met `x` with; returns the gradient by x, and `gradient` itself.
pub(super) fn through(
    x: Vec<f32>,
    weight: &Param<Tensor<2>>,
    gradient: Vec<f32>,
    name: String,
    grads: &mut Grads,
) -> Result<(Vec<f32>, Vec<f32>), Unreadable> {
    let weight = weight.val().without_autodiff();
    let [rows, columns] = weight.dims();
    let (x, gradient) = (tensor(x, &weight, rows), tensor(gradient, &weight, columns));
    grads.insert(name, x.transpose().matmul(gradient.clone()).reshape([rows * columns]));
    let by_x = gradient.clone().matmul(weight.transpose());
    Ok((read(by_x)?, read(gradient)?))
}

/// As [`Affine::forward`], and x itself.
pub(super) fn affine(x: Vec<f32>, layer: &Affine) -> Result<(Vec<f32>, Vec<f32>), Unreadable> {
    let (mut y, x) = multiply(x, &layer.weight)?;
    let bias = numbers(&layer.bias)?;
    vectorize(
        #[inline(always)]
        || {
            for row in y.chunks_exact_mut(bias.len().max(1)) {
                for (y, bias) in row.iter_mut().zip(&bias) {
                    *y += bias;
                }
            }
        },
    );
    Ok((y, x))
}

/// As [`through`], for an [`Affine`]; returns the gradient by x.
pub(super) fn through_affine(
    x: Vec<f32>,
    layer: &Affine,
    gradient: Vec<f32>,
    name: &str,
    grads: &mut Grads,
) -> Result<Vec<f32>, Unreadable> {
    let columns = layer.bias.dims()[0];
    let mut sums = vec![0.0_f32; columns];
    vectorize(
        #[inline(always)]
        || {
            for row in gradient.chunks_exact(columns.max(1)) {
                for (sum, x) in sums.iter_mut().zip(row) {
                    *sum += x;
                }
            }
        },
    );
    put(&layer.bias, sums, format!("{name}.bias"), grads);
    Ok(through(x, &layer.weight, gradient, format!("{name}.weight"), grads)?.0)
}

/// Returns a parameter's numbers.
pub(super) fn numbers<const D: usize>(parameter: &Param<Tensor<D>>) -> Result<Vec<f32>, Unreadable> {
    read(parameter.val().without_autodiff())
}

/// Puts a gradient that is in our memory where its parameter is.
pub(super) fn put<const D: usize>(like: &Param<Tensor<D>>, values: Vec<f32>, name: String, grads: &mut Grads) {
    let count = values.len();
    grads.insert(name, Tensor::from_data(TensorData::new(values, [count]), &like.val().device().inner()));
}

fn tensor(values: Vec<f32>, like: &Tensor<2>, columns: usize) -> Tensor<2> {
    let rows = values.len() / columns.max(1);
    Tensor::from_data(TensorData::new(values, [rows, columns]), &like.device())
}
