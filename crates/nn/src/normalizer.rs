//! Running normalization of observations (thesis 4.3.1: "observations are normalized using a running mean").

use lifelike_checkpoint::{Checkpoint, CheckpointError};
use lifelike_simd::{InstructionSet, Simd, Task};

/// Variance below which a dimension is treated as constant and only centred.
const MIN_VARIANCE: f64 = 1e-8;

/// Mean and variance of everything seen, merged batch by batch (Chan et al. 1979) in f64.
#[derive(Debug, Clone, PartialEq)]
pub struct RunningNormalizer {
    mean: Vec<f64>,
    variance: Vec<f64>,
    count: f64,
    count_cap: f64,
    clip: f32,
    frozen: bool,
}

impl RunningNormalizer {
    /// For vectors of `size` numbers; clips to ±5 and weighs all samples alike.
    pub fn new(size: usize) -> Self {
        Self {
            mean: vec![0.0; size],
            variance: vec![1.0; size],
            count: 0.0,
            count_cap: f64::INFINITY,
            clip: 5.0,
            frozen: false,
        }
    }

    /// Returns the length of the vectors.
    pub fn size(&self) -> usize {
        self.mean.len()
    }

    /// Returns the mean of each dimension.
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// Returns the variance (population) of each dimension.
    pub fn variance(&self) -> &[f64] {
        &self.variance
    }

    /// Samples that the statistics stand for (at most the cap).
    pub fn count(&self) -> f64 {
        self.count
    }

    /// Freezes or thaws: while frozen, [`Self::update`] does nothing: for evaluation and deployment.
    pub fn set_frozen(&mut self, frozen: bool) {
        self.frozen = frozen;
    }

    /// Takes in a batch of rows `[N, size]`. Rows with a non-finite number are left out.
    pub fn update(&mut self, rows: &[f32]) {
        let size = self.size();
        if self.frozen || size == 0 {
            return;
        }
        let Some(first) = rows.chunks_exact(size).find(|row| is_finite(row)) else { return };
        let origin: Vec<f64> = first.iter().map(|x| f64::from(*x)).collect();
        let (mut mean, mut square) = (vec![0.0; size], vec![0.0; size]);
        let sums = Sums { rows, origin: &origin, sum: &mut mean, square: &mut square };
        let n = InstructionSet::chosen().run(sums);
        for ((sum, square), origin) in mean.iter_mut().zip(&mut square).zip(&origin) {
            *square = (*square - *sum * *sum / n).max(0.0);
            *sum = origin + *sum / n;
        }
        self.absorb(n, &mean, &square);
    }

    /// Takes in `n` samples with these means and sums of squares about them (Chan et al. 1979).
    fn absorb(&mut self, n: f64, mean: &[f64], square: &[f64]) {
        let total = self.count + n;
        for i in 0..self.size() {
            let delta = mean[i] - self.mean[i];
            let merged = self.variance[i] * self.count + square[i] + delta * delta * self.count * n / total;
            self.mean[i] += delta * n / total;
            self.variance[i] = merged / total;
        }
        self.count = total.min(self.count_cap);
    }

    /// Sums over what this normalizer has seen, which add up over several: samples, then for each number its sum and that of
    /// its square, `[1 + 2 size]`.
    pub fn moments(&self) -> Vec<f64> {
        let sums = self.mean.iter().map(|m| m * self.count);
        let squares = self.mean.iter().zip(&self.variance).map(|(m, v)| (v + m * m) * self.count);
        [self.count].into_iter().chain(sums).chain(squares).collect()
    }

    /// Takes in what others have seen: sums of their [`Self::moments`], of vectors of this size.
    pub fn merge(&mut self, moments: &[f64]) {
        let size = self.size();
        let n = moments.first().copied().unwrap_or(0.0);
        if self.frozen || moments.len() != 1 + 2 * size || n <= 0.0 {
            return;
        }
        let (sums, squares) = moments[1..].split_at(size);
        let mean: Vec<f64> = sums.iter().map(|sum| sum / n).collect();
        let about: Vec<f64> = squares.iter().zip(&mean).map(|(s, m)| (s - n * m * m).max(0.0)).collect();
        self.absorb(n, &mean, &about);
    }

    /// Returns the same for other rows: `places` says which of these numbers each is; what is new has the scale that `fresh` has.
    #[must_use]
    pub fn rearranged(&self, fresh: &Self, places: &[Option<usize>]) -> Self {
        let pick = |stored: &[f64], fresh: &[f64]| {
            let number = |(i, place): (usize, &Option<usize>)| place.map_or(fresh[i], |place| stored[place]);
            places.iter().enumerate().map(number).collect()
        };
        Self { mean: pick(&self.mean, &fresh.mean), variance: pick(&self.variance, &fresh.variance), ..*self }
    }

    /// Normalizes to (x − mean) / std, clipped, in place, for rows `[N, size]`.
    pub fn normalize(&self, rows: &mut [f32]) {
        let (mean, inverse) = self.affine();
        for row in rows.chunks_exact_mut(self.size().max(1)) {
            normalize_row(row, &mean, &inverse, self.clip);
        }
    }

    /// Appends rows `[N, size]` as [`Self::normalize`] would leave them: one way through the memory instead of two.
    pub fn append_normalized(&self, rows: &[f32], out: &mut Vec<f32>) {
        let (mean, inverse) = self.affine();
        for row in rows.chunks_exact(self.size().max(1)) {
            let start = out.len();
            out.extend_from_slice(row);
            normalize_row(&mut out[start..], &mean, &inverse, self.clip);
        }
    }

    fn affine(&self) -> (Vec<f32>, Vec<f32>) {
        let inverse = |v: &f64| if *v > MIN_VARIANCE { (1.0 / v.sqrt()) as f32 } else { 1.0 };
        (self.mean.iter().map(|m| *m as f32).collect(), self.variance.iter().map(inverse).collect())
    }

    /// Writes the whole state under `prefix` (exact bits).
    pub fn save_into(&self, checkpoint: &mut Checkpoint, prefix: &str) -> Result<(), CheckpointError> {
        let size = self.size();
        checkpoint.put_f64(&format!("{prefix}.mean"), &[size], self.mean.clone())?;
        checkpoint.put_f64(&format!("{prefix}.variance"), &[size], self.variance.clone())?;
        let frozen = f64::from(u8::from(self.frozen));
        let rest = vec![self.count, self.count_cap, f64::from(self.clip), frozen];
        checkpoint.put_f64(&format!("{prefix}.settings"), &[4], rest)
    }

    /// Reads a normalizer for vectors of `size` numbers.
    pub fn load_from(checkpoint: &Checkpoint, prefix: &str, size: usize) -> Result<Self, CheckpointError> {
        let rest = checkpoint.f64s(&format!("{prefix}.settings"), &[4])?;
        Ok(Self {
            mean: checkpoint.f64s(&format!("{prefix}.mean"), &[size])?,
            variance: checkpoint.f64s(&format!("{prefix}.variance"), &[size])?,
            count: rest[0],
            count_cap: rest[1],
            clip: rest[2] as f32,
            frozen: rest[3] != 0.0,
        })
    }
}

/// Returns true when all numbers of a row are finite. It looks at all of them, which is quicker than to stop at one.
#[inline(always)]
fn is_finite(row: &[f32]) -> bool {
    row.iter().fold(true, |finite, x| finite & x.is_finite())
}

fn normalize_row(row: &mut [f32], mean: &[f32], inverse: &[f32], clip: f32) {
    for ((x, m), s) in row.iter_mut().zip(mean).zip(inverse) {
        *x = ((*x - m) * s).clamp(-clip, clip);
    }
}

/// Sums of the finite rows' differences from `origin` and of their squares, and the number of these rows. One pass: an origin
/// that is one of the rows is near enough to the mean to lose no digits.
struct Sums<'a> {
    rows: &'a [f32],
    origin: &'a [f64],
    sum: &'a mut [f64],
    square: &'a mut [f64],
}

impl Task for Sums<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> f64 {
        let Self { rows, origin, sum, square } = self;
        let mut n = 0.0;
        for row in rows.chunks_exact(origin.len()).filter(|row| is_finite(row)) {
            n += 1.0;
            for (((sum, square), x), origin) in sum.iter_mut().zip(square.iter_mut()).zip(row).zip(origin) {
                let difference = f64::from(*x) - origin;
                *sum += difference;
                *square += difference * difference;
            }
        }
        n
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn rows(n: usize) -> Vec<f32> {
        (0..3 * n).map(|i| ((i * 7919) % 1000) as f32 * 0.01 + if i % 3 == 2 { 1000.0 } else { 0.0 }).collect()
    }

    #[test]
    fn batches_merge_to_the_statistics_of_all_rows() {
        let all = rows(1000);
        let mut n = RunningNormalizer::new(3);
        for batch in [&all[..30], &all[30..33], &all[33..2400], &all[2400..]] {
            n.update(batch);
        }
        for d in 0..3 {
            let column: Vec<f64> = all.iter().skip(d).step_by(3).map(|x| f64::from(*x)).collect();
            let mean = column.iter().sum::<f64>() / 1000.0;
            let variance = column.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 1000.0;
            assert!((n.mean()[d] - mean).abs() < 1e-9 * mean.abs(), "mean {d}");
            assert!((n.variance()[d] - variance).abs() < 1e-9 * variance, "variance {d}");
        }
        assert_eq!(n.count(), 1000.0);
    }

    #[test]
    fn what_two_have_seen_adds_up_to_what_one_sees() {
        let rows: Vec<f32> = (0..60).map(|i| ((i * 37) % 23) as f32 * 0.3 + 100.0).collect();
        let seen = |rows: &[f32]| {
            let mut normalizer = RunningNormalizer::new(3);
            normalizer.update(rows);
            normalizer
        };
        let (first, second) = (seen(&rows[..21]), seen(&rows[21..]));
        let sum: Vec<f64> = first.moments().iter().zip(second.moments()).map(|(a, b)| a + b).collect();
        let (mut merged, whole) = (seen(&[]), seen(&rows));
        merged.merge(&sum);
        assert_eq!(merged.count(), 20.0);
        let pairs = merged.mean().iter().zip(whole.mean()).chain(merged.variance().iter().zip(whole.variance()));
        // A mean of 100 squared leaves eleven digits of the variance.
        pairs.for_each(|(a, b)| assert!((a - b).abs() < 1e-9, "{a} {b}"));
    }

    #[test]
    fn normalizing_centres_scales_and_clips() {
        let mut n = RunningNormalizer::new(2);
        n.update(&[1.0, 5.0, 3.0, 5.0]);
        let mut x = [3.0, 5.5, 100.0, 5.0];
        n.normalize(&mut x);
        assert_eq!(x, [1.0, 0.5, 5.0, 0.0], "the constant second dimension is only centred");
        let mut appended = vec![7.0];
        n.append_normalized(&[3.0, 5.5, 100.0, 5.0], &mut appended);
        assert_eq!(appended, [7.0, 1.0, 0.5, 5.0, 0.0]);
    }

    #[test]
    fn frozen_ignores_updates_and_non_finite_rows_never_count() {
        let mut n = RunningNormalizer::new(1);
        n.update(&[1.0, f32::NAN, 3.0, f32::INFINITY]);
        assert_eq!((n.mean()[0], n.count()), (2.0, 2.0));
        n.set_frozen(true);
        let before = n.clone();
        n.update(&[100.0]);
        assert_eq!(n, before);
    }

    #[test]
    fn saved_and_loaded_is_equal_bit_for_bit() {
        let mut n = RunningNormalizer::new(3);
        n.update(&rows(17));
        let mut c = Checkpoint::new();
        n.save_into(&mut c, "obs").unwrap();
        assert_eq!(RunningNormalizer::load_from(&c, "obs", 3).unwrap(), n);
        assert!(RunningNormalizer::load_from(&c, "obs", 4).is_err());
    }
}
