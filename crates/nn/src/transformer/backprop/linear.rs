//! Products with weights, and their gradients, in the kernels of [`crate::rows`].

use burn::module::Param;
use burn::tensor::{Tensor, TensorData};

use super::Grads;
use crate::numbers::{Unreadable, read};
use crate::rows::{bias_gradient, product, product_with_transposed, weight_gradient};
use crate::transformer::heads::Affine;

/// Returns x · weight.
pub(super) fn multiply(x: &[f32], weight: &Param<Tensor<2>>) -> Result<Vec<f32>, Unreadable> {
    Ok(product(x, &numbers(weight)?, weight.dims(), &[]))
}

/// Returns the gradient by the x that [`multiply`] met.
pub(super) fn by_input(weight: &Param<Tensor<2>>, gradient: &[f32]) -> Result<Vec<f32>, Unreadable> {
    Ok(product_with_transposed(gradient, &numbers(weight)?, weight.dims()))
}

/// Puts the gradient of a weight that [`multiply`] met `x` with.
pub(super) fn learn(x: &[f32], weight: &Param<Tensor<2>>, gradient: &[f32], name: String, grads: &mut Grads) {
    let shape = weight.dims();
    let mut sum = vec![0.0; shape[0] * shape[1]];
    weight_gradient(x, gradient, shape, &mut sum);
    put(weight, sum, name, grads);
}

/// [`learn`] and [`by_input`].
pub(super) fn through(
    x: &[f32],
    weight: &Param<Tensor<2>>,
    gradient: &[f32],
    name: String,
    grads: &mut Grads,
) -> Result<Vec<f32>, Unreadable> {
    learn(x, weight, gradient, name, grads);
    by_input(weight, gradient)
}

/// As [`Affine::forward`].
pub(super) fn affine(x: &[f32], layer: &Affine) -> Result<Vec<f32>, Unreadable> {
    Ok(product(x, &numbers(&layer.weight)?, layer.weight.dims(), &numbers(&layer.bias)?))
}

/// As [`learn`], for an [`Affine`].
pub(super) fn learn_affine(x: &[f32], layer: &Affine, gradient: &[f32], name: &str, grads: &mut Grads) {
    let mut sums = vec![0.0_f32; layer.bias.dims()[0]];
    bias_gradient(gradient, &mut sums);
    put(&layer.bias, sums, format!("{name}.bias"), grads);
    learn(x, &layer.weight, gradient, format!("{name}.weight"), grads);
}

/// As [`through`], for an [`Affine`].
pub(super) fn through_affine(
    x: &[f32],
    layer: &Affine,
    gradient: &[f32],
    name: &str,
    grads: &mut Grads,
) -> Result<Vec<f32>, Unreadable> {
    learn_affine(x, layer, gradient, name, grads);
    by_input(&layer.weight, gradient)
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
