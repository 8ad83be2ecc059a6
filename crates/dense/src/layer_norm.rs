//! Layer normalization (Ba et al. 2016) with a gain and no bias.

/// Numbers that are summed beside each other, so that a compiler uses vector instructions.
const LANES: usize = 8;

/// Normalises every row of `rows` to mean 0 and variance 1 and multiplies by `gain`, in place.
///
/// # Shapes
/// `rows: [N, C]`, `gain: [C]`.
pub fn layer_norm(rows: &mut [f32], gain: &[f32], epsilon: f32) {
    let width = gain.len().max(1);
    for row in rows.chunks_exact_mut(width) {
        let mean = sum(row, |x| x) / width as f32;
        let variance = sum(row, |x| (x - mean) * (x - mean)) / width as f32;
        let inverse = 1.0 / (variance + epsilon).sqrt();
        row.iter_mut().zip(gain).for_each(|(x, gain)| *x = (*x - mean) * (inverse * gain));
    }
}

fn sum(row: &[f32], term: impl Fn(f32) -> f32) -> f32 {
    let (groups, rest) = row.as_chunks::<LANES>();
    let mut lanes = [0.0_f32; LANES];
    for group in groups {
        lanes.iter_mut().zip(group).for_each(|(sum, x)| *sum += term(*x));
    }
    rest.iter().fold(lanes.iter().sum(), |sum: f32, x| sum + term(*x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_get_mean_zero_and_the_gain_as_deviation() {
        let mut rows: Vec<f32> = (0..2 * 19).map(|i| ((i * 7) % 11) as f32 + 100.0 * (i / 19) as f32).collect();
        layer_norm(&mut rows, &[3.0; 19], 1e-5);
        for row in rows.chunks_exact(19) {
            let mean = row.iter().sum::<f32>() / 19.0;
            let variance = row.iter().map(|x| (x - mean).powi(2)).sum::<f32>() / 19.0;
            assert!(mean.abs() < 1e-5 && (variance - 9.0).abs() < 1e-3, "{mean} {variance}");
        }
    }
}
