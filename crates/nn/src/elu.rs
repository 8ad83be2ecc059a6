//! The exponential linear unit of Clevert et al. 2016.

use burn::tensor::Tensor;

/// Returns ELU with α = 1: x for x > 0, exp(x) − 1 otherwise, with a finite gradient everywhere.
///
/// burn 0.22's own `activation::elu` computes exp(x) before it masks, so its gradient is NaN from x ≥ 89 on. Here the
/// exponential only ever sees non-positive numbers.
pub fn elu<const D: usize>(x: Tensor<D>) -> Tensor<D> {
    let negative = x.clone().clamp_max(0.0).exp().sub_scalar(1.0);
    x.clone().mask_where(x.lower_equal_elem(0.0), negative)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::device;

    #[test]
    fn value_and_gradient_stay_finite_far_from_zero() {
        let xs = [-1e30_f32, -200.0, -1.0, -0.0, 0.0, 1.0, 89.0, 1e30];
        let x = Tensor::<1>::from_floats(xs, &device::training()).require_grad();
        let y = elu(x.clone());
        let mut grads = y.clone().sum().backward();
        let gradient = x.grad_remove(&mut grads).unwrap().try_to_vec_as::<f32>().unwrap();
        let value = y.try_to_vec_as::<f32>().unwrap();
        for (i, x) in xs.into_iter().enumerate() {
            let (f, d) = if x > 0.0 { (x, 1.0) } else { (x.exp_m1(), x.exp()) };
            assert!((value[i] - f).abs() <= 1e-7 * f.abs().max(1.0), "elu({x}) = {}", value[i]);
            assert!((gradient[i] - d).abs() <= 1e-7, "elu'({x}) = {}", gradient[i]);
        }
    }
}
