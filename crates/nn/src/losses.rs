//! Loss terms. Each returns one number per row, so callers choose how rows are weighed.

use burn::tensor::Tensor;

/// Returns the KL divergence of N(μ, e^{log σ²}) from the standard normal, summed over the latent (Kingma & Welling 2013, App. B):
/// ½ Σ (μ² + σ² − 1 − log σ²).
///
/// # Shapes
/// Two `[B, d]` to `[B]`.
pub fn kl_from_standard_normal(mean: Tensor<2>, log_variance: Tensor<2>) -> Tensor<1> {
    let per_dimension = mean.square() + log_variance.clone().exp() - log_variance.add_scalar(1.0);
    per_dimension.sum_dim(1).squeeze_dim::<1>(1).mul_scalar(0.5)
}

/// Returns rotation matrices' first two columns from 6D numbers by Gram-Schmidt (Zhou et al. 2019, eq. 15).
///
/// # Shapes
/// `[N, 6]` (first column, then second) to two `[N, 3]`.
pub fn gram_schmidt(six: Tensor<2>) -> (Tensor<2>, Tensor<2>) {
    let a = six.clone().narrow(1, 0, 3);
    let b = six.narrow(1, 3, 3);
    let x = unit(a);
    let along = (x.clone() * b.clone()).sum_dim(1);
    let y = unit(b - x.clone() * along);
    (x, y)
}

/// Returns a direction; the small number keeps the gradient finite for a zero vector (which training never aims at).
fn unit(v: Tensor<2>) -> Tensor<2> {
    let norm = v.clone().square().sum_dim(1).add_scalar(1e-12).sqrt();
    v / norm
}

/// Returns ‖R(a) − R(b)‖_F² for 6D rotations (thesis eq. 4.4).
///
/// # Shapes
/// Two `[N, 6]` to `[N]`.
pub fn rotation_distance_squared(a: Tensor<2>, b: Tensor<2>) -> Tensor<1> {
    let (ax, ay) = gram_schmidt(a);
    let (bx, by) = gram_schmidt(b);
    let (az, bz) = (cross(&ax, &ay), cross(&bx, &by));
    let square = |d: Tensor<2>| d.square().sum_dim(1).squeeze_dim::<1>(1);
    square(ax - bx) + square(ay - by) + square(az - bz)
}

fn cross(a: &Tensor<2>, b: &Tensor<2>) -> Tensor<2> {
    let part = |v: &Tensor<2>, i: usize| v.clone().narrow(1, i, 1);
    let minor = |i: usize, j: usize| part(a, i) * part(b, j) - part(a, j) * part(b, i);
    Tensor::cat(vec![minor(1, 2), minor(2, 0), minor(0, 1)], 1)
}
