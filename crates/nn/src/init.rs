//! Initial weights, written from an addressed seed: the same numbers on every device and at every thread count.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, Uniform};

/// Returns a `[rows, columns]` matrix with orthonormal rows or columns (whichever are fewer), times `gain` (Saxe et al. 2014).
pub fn orthogonal(rng: &mut ChaCha8Rng, rows: usize, columns: usize, gain: f64) -> Vec<f32> {
    let (count, length) = (rows.min(columns), rows.max(columns));
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(count);
    while basis.len() < count {
        let mut v: Vec<f64> = (0..length).map(|_| StandardNormal.sample(rng)).collect();
        // Twice is enough (Kahan, Parlett): the second pass removes what rounding left of the first.
        for _ in 0..2 {
            for b in &basis {
                let along: f64 = v.iter().zip(b).map(|(x, y)| x * y).sum();
                v.iter_mut().zip(b).for_each(|(x, y)| *x -= along * y);
            }
        }
        let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        if norm > 1e-6 {
            v.iter_mut().for_each(|x| *x /= norm);
            basis.push(v);
        }
    }
    let mut out = Vec::with_capacity(rows * columns);
    for r in 0..rows {
        for c in 0..columns {
            let x = if rows <= columns { basis[r][c] } else { basis[c][r] };
            out.push((x * gain) as f32);
        }
    }
    out
}

/// Draws `count` numbers from U(−b, b) with b = gain √(3 / fan_in): He initialization for gain √2 (He et al. 2015), PyTorch's
/// default for linear and convolution layers for gain 1/√3.
pub fn uniform_by_fan_in(rng: &mut ChaCha8Rng, count: usize, fan_in: usize, gain: f64) -> Vec<f32> {
    let bound = gain * (3.0 / fan_in.max(1) as f64).sqrt();
    match Uniform::new_inclusive(-bound, bound) {
        Ok(uniform) => (0..count).map(|_| uniform.sample(rng) as f32).collect(),
        Err(_) => vec![0.0; count],
    }
}

/// Draws `count` numbers from the normal distribution of mean 0 and this standard deviation.
pub fn normal(rng: &mut ChaCha8Rng, count: usize, deviation: f64) -> Vec<f32> {
    (0..count)
        .map(|_| {
            let x: f64 = StandardNormal.sample(rng);
            (x * deviation) as f32
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use lifelike_checkpoint::rng::stream;

    #[test]
    fn the_shorter_side_is_orthonormal_times_gain() {
        for (rows, columns) in [(7, 20), (20, 7), (12, 12), (1, 5)] {
            let w = orthogonal(&mut stream(1, "test", 0, 0), rows, columns, 1.5);
            let at =
                |i: usize, k: usize| f64::from(if rows <= columns { w[i * columns + k] } else { w[k * columns + i] });
            let (count, length) = (rows.min(columns), rows.max(columns));
            for i in 0..count {
                for j in 0..count {
                    let dot: f64 = (0..length).map(|k| at(i, k) * at(j, k)).sum();
                    let expected = if i == j { 2.25 } else { 0.0 };
                    assert!((dot - expected).abs() < 1e-5, "{rows}x{columns}: <{i},{j}> = {dot}");
                }
            }
        }
    }
}
