//! The diagonal Gaussian that a policy draws from (thesis 4.3.1).

const HALF_LOG_2_PI: f64 = 0.918_938_533_204_672_7;

/// log N(mean + exp(log_std) · noise; mean, exp(log_std)²), summed over the dimensions.
pub fn log_probability_of_noise(noise: &[f32], log_std: &[f32]) -> f32 {
    let square: f64 = noise.iter().map(|z| f64::from(*z).powi(2)).sum();
    let scale: f64 = log_std.iter().map(|l| f64::from(*l)).sum();
    (-0.5 * square - scale - log_std.len() as f64 * HALF_LOG_2_PI) as f32
}

/// KL(old ‖ new) between diagonal Gaussians, summed over the dimensions: one number for each row.
///
/// # Shapes
/// Means `[B, A]`, log standard deviations `[A]` → `[B]`.
pub fn divergence(old: (&[f32], &[f32]), new: (&[f32], &[f32])) -> Vec<f64> {
    let ((old_means, old_log_std), (new_means, new_log_std)) = (old, new);
    let precision = |log_std: &f32| 0.5 * f64::from(-2.0 * log_std).exp();
    let scales = old_log_std
        .iter()
        .zip(new_log_std)
        .map(|(old, new)| f64::from(2.0 * old).exp() * precision(new) + f64::from(new - old) - 0.5);
    let scale: f64 = scales.sum();
    let rows = old_means.chunks_exact(old_log_std.len()).zip(new_means.chunks_exact(new_log_std.len()));
    let shift = |(old, new): (&[f32], &[f32])| -> f64 {
        let apart = old.iter().zip(new).zip(new_log_std);
        apart.map(|((old, new), log_std)| f64::from(old - new).powi(2) * precision(log_std)).sum()
    };
    rows.map(|row| shift(row) + scale).collect()
}

/// Differential entropy, summed over the dimensions.
pub fn entropy(log_std: &[f32]) -> f64 {
    log_std.iter().map(|l| f64::from(*l) + HALF_LOG_2_PI + 0.5).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn densities_match_the_formula_and_integrate_to_one() {
        // N(0.5; 0.2, 0.5²) · N(−1; 1, 2²) by hand: z = (.6, −1); ½(.36 + 1) = .68; log stds sum to 0; log 2π.
        let expected = -0.68 - (2.0 * std::f32::consts::PI).ln();
        let noise = log_probability_of_noise(&[0.6, -1.0], &[0.5_f32.ln(), 2.0_f32.ln()]);
        assert!((noise - expected).abs() < 1e-6);
        // In one dimension the density integrates to one.
        let n = 4001;
        let (log_std, width) = (0.2_f32, 20.0 / (n - 1) as f64);
        let density = |i: usize| {
            let x = -10.0 + width as f32 * i as f32;
            f64::from(log_probability_of_noise(&[(x - 0.3) / log_std.exp()], &[log_std]).exp())
        };
        let mass: f64 = (0..n).map(|i| density(i) * width).sum();
        assert!((mass - 1.0).abs() < 1e-5, "{mass}");
    }

    #[test]
    fn divergence_is_zero_for_equals_and_matches_the_closed_form() {
        let (means, log_std) = ([0.3, -2.0], [-0.7, 0.4]);
        assert!(divergence((&means, &log_std), (&means, &log_std))[0].abs() < 1e-6);
        // KL(N(0,1) ‖ N(1,2²)) = ln 2 + (1 + 1)/8 − ½; the second dimension is equal.
        let new_log_std = [2.0_f32.ln(), 0.3];
        let kl = divergence((&[0.0, 0.0], &[0.0, 0.3]), (&[1.0, 0.0], &new_log_std));
        assert!((kl[0] - (2.0_f64.ln() - 0.25)).abs() < 1e-6, "{kl:?}");
    }

    #[test]
    fn entropy_of_a_unit_gaussian() {
        assert!((entropy(&[0.0, 0.0, 0.0]) - 1.5 * (1.0 + (2.0 * std::f64::consts::PI).ln())).abs() < 1e-9);
    }
}
