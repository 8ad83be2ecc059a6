//! Attention with linear biases (ALiBi, Press et al. 2022): each head prefers what is near, and each to another degree.

/// Returns the slope of each head, as the paper's authors publish it (`get_slopes` of their code): for a power of two the
/// geometric series 2^(−8/h), 2^(−16/h), .., 2^(−8). For other counts the series of the power of two below, then every
/// second slope of the series of twice that power.
pub fn slopes(heads: usize) -> Vec<f64> {
    let series = |n: usize| (1..=n).map(move |i| (-8.0 * i as f64 / n as f64).exp2());
    if heads == 0 {
        return Vec::new();
    }
    let below = 1_usize << heads.ilog2();
    series(below).chain(series(2 * below).step_by(2)).take(heads).collect()
}

/// Returns the bias that is added to the scores before the softmax: −slope · |distance|, row-major `[heads, T, T]`. Both directions alike,
/// because every token sees the whole sequence; positions are in tokens and may be fractions.
pub fn bias(heads: usize, positions: &[f64]) -> Vec<f32> {
    let mut out = Vec::with_capacity(heads * positions.len() * positions.len());
    for slope in slopes(heads) {
        for from in positions {
            out.extend(positions.iter().map(|to| (-slope * (from - to).abs()) as f32));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_the_published_ones() {
        assert_eq!(slopes(8), [0.5, 0.25, 0.125, 0.0625, 0.03125, 0.015625, 0.0078125, 0.00390625]);
        assert_eq!(slopes(4), [0.25, 0.0625, 0.015625, 0.00390625]);
        assert_eq!(slopes(1), [0.00390625]);
        // The authors' code: get_slopes(6) = get_slopes(4) + get_slopes(8)[0::2][:2].
        assert_eq!(slopes(6), [0.25, 0.0625, 0.015625, 0.00390625, 0.5, 0.125]);
        assert!(slopes(0).is_empty());
    }

    #[test]
    fn the_bias_is_minus_slope_times_distance_both_ways() {
        assert_eq!(
            bias(1, &[0.0, 1.0, 2.5]).iter().map(|b| b * 256.0).collect::<Vec<_>>(),
            [-0.0, -1.0, -2.5, -1.0, -0.0, -1.5, -2.5, -1.5, -0.0]
        );
    }
}
