//! The diagonal Gaussian that a policy draws from (thesis 4.3.1).

use burn::tensor::Tensor;

const HALF_LOG_2_PI: f64 = 0.918_938_533_204_672_7;

/// log N(action; mean, exp(log_std)²), summed over the dimensions.
///
/// # Shapes
/// `mean, action: [B, A]`, `log_std: [A]` → `[B]`.
pub fn log_probability(mean: Tensor<2>, log_std: Tensor<1>, action: Tensor<2>) -> Tensor<1> {
    let size = log_std.dims()[0] as f64;
    let inverse = log_std.clone().neg().exp().unsqueeze::<2>();
    let z = (action - mean) * inverse;
    z.square().sum_dim(1).squeeze_dim::<1>(1).mul_scalar(-0.5) - log_std.sum() - size * HALF_LOG_2_PI
}

/// The same for numbers that were drawn as `mean + std · noise`.
pub fn log_probability_of_noise(noise: &[f32], log_std: &[f32]) -> f32 {
    let square: f64 = noise.iter().map(|z| f64::from(*z).powi(2)).sum();
    let scale: f64 = log_std.iter().map(|l| f64::from(*l)).sum();
    (-0.5 * square - scale - log_std.len() as f64 * HALF_LOG_2_PI) as f32
}

/// KL(old ‖ new) between diagonal Gaussians, summed over the dimensions.
///
/// # Shapes
/// Means `[B, A]`, log standard deviations `[A]` → `[B]`.
pub fn divergence(
    old_mean: Tensor<2>,
    old_log_std: Tensor<1>,
    new_mean: Tensor<2>,
    new_log_std: Tensor<1>,
) -> Tensor<1> {
    let half_inverse = new_log_std.clone().mul_scalar(-2.0).exp().mul_scalar(0.5);
    let scale = old_log_std.clone().mul_scalar(2.0).exp() * half_inverse.clone() + new_log_std - old_log_std - 0.5;
    let shift = (old_mean - new_mean).square() * half_inverse.unsqueeze::<2>();
    shift.sum_dim(1).squeeze_dim::<1>(1) + scale.sum()
}

/// Differential entropy, summed over the dimensions: a scalar tensor.
pub fn entropy(log_std: Tensor<1>) -> Tensor<1> {
    let size = log_std.dims()[0] as f64;
    log_std.sum() + size * (HALF_LOG_2_PI + 0.5)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use lifelike_nn::device;

    fn rows(x: Tensor<1>) -> Vec<f32> {
        x.try_to_vec_as::<f32>().unwrap()
    }

    #[test]
    fn densities_multiply_to_one_over_a_grid_and_match_the_formula() {
        let d = device::inference();
        // N(0.5; 0.2, 0.5²) · N(−1; 1, 2²) by hand: z = (.6, −1); ½(.36 + 1) = .68; log stds sum to 0; log 2π.
        let log_std = Tensor::<1>::from_floats([0.5_f32.ln(), 2.0_f32.ln()], &d);
        let p = log_probability(Tensor::from_floats([[0.2, 1.0]], &d), log_std, Tensor::from_floats([[0.5, -1.0]], &d));
        let expected = -0.68 - (2.0 * std::f32::consts::PI).ln();
        assert!((rows(p)[0] - expected).abs() < 1e-6);
        let noise = log_probability_of_noise(&[0.6, -1.0], &[0.5_f32.ln(), 2.0_f32.ln()]);
        assert!((noise - expected).abs() < 1e-6);
        // In one dimension the density integrates to one.
        let n = 4001;
        let xs: Vec<f32> = (0..n).map(|i| -10.0 + 20.0 * i as f32 / (n - 1) as f32).collect();
        let x = Tensor::<1>::from_floats(xs.as_slice(), &d).reshape([n, 1]);
        let p = log_probability(x.zeros_like() + 0.3, Tensor::from_floats([0.2], &d), x);
        let mass: f64 = rows(p).iter().map(|p| f64::from(p.exp()) * 20.0 / (n - 1) as f64).sum();
        assert!((mass - 1.0).abs() < 1e-5, "{mass}");
    }

    #[test]
    fn divergence_is_zero_for_equals_and_matches_the_closed_form() {
        let d = device::inference();
        let (m, s) = (Tensor::<2>::from_floats([[0.3, -2.0]], &d), Tensor::<1>::from_floats([-0.7, 0.4], &d));
        assert!(rows(divergence(m.clone(), s.clone(), m.clone(), s.clone()))[0].abs() < 1e-6);
        // KL(N(0,1) ‖ N(1,2²)) = ln 2 + (1 + 1)/8 − ½; the second dimension is equal.
        let old = Tensor::<2>::from_floats([[0.0, 0.0]], &d);
        let new = Tensor::<2>::from_floats([[1.0, 0.0]], &d);
        let kl =
            divergence(old, Tensor::from_floats([0.0, 0.3], &d), new, Tensor::from_floats([2.0_f32.ln(), 0.3], &d));
        assert!((rows(kl)[0] - (2.0_f32.ln() - 0.25)).abs() < 1e-6);
    }

    #[test]
    fn entropy_of_a_unit_gaussian() {
        let h = rows(entropy(Tensor::from_floats([0.0, 0.0, 0.0], &device::inference())))[0];
        assert!((h - 1.5 * (1.0 + (2.0 * std::f32::consts::PI).ln())).abs() < 1e-5);
    }
}
