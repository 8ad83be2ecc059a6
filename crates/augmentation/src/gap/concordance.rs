//! Agreement of two signals.

/// Returns Lin's concordance correlation coefficient: 2 s_xy / (s_x² + s_y² + (x̄ - ȳ)²) with the variances over n. 1 where both are the
/// same constant; NaN of nothing.
///
/// # Panics
/// The lengths differ.
pub fn concordance(x: &[f64], y: &[f64]) -> f64 {
    assert_eq!(x.len(), y.len(), "pairs of a concordance correlation");
    let n = x.len() as f64;
    let (mean_x, mean_y) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let covariance = x.iter().zip(y).map(|(x, y)| (x - mean_x) * (y - mean_y)).sum::<f64>() / n;
    let variance = |x: &[f64], mean: f64| x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
    let below = variance(x, mean_x) + variance(y, mean_y) + (mean_x - mean_y).powi(2);
    if below == 0.0 { 1.0 } else { 2.0 * covariance / below }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_lins_coefficient() {
        let (x, y) = ([1.0, 2.0, 3.0, 4.0, 5.0], [1.1, 1.9, 3.3, 3.8, 5.5]);
        // NumPy: covariance 2.14 and variances 2 and 2.3456 over n; the means differ by 0.12.
        let expected = 2.0 * 2.14 / (2.0 + 2.3456 + 0.0144);
        assert!((concordance(&x, &y) - expected).abs() < 1e-12, "{} {expected}", concordance(&x, &y));
        assert_eq!(concordance(&x, &x), 1.0);
        assert!(concordance(&x, &[3.0; 5]).abs() < 1e-12, "a constant follows nothing");
        assert_eq!(concordance(&[2.0; 4], &[2.0; 4]), 1.0);
    }
}
