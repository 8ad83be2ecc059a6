//! Numbers of different units and sizes made comparable: each less its mean and by its standard deviation.

use lifelike_checkpoint::{Checkpoint, CheckpointError};

/// Mean and standard deviation of each number of a row.
#[derive(Debug, Clone, PartialEq)]
pub struct Standardizer {
    mean: Vec<f64>,
    std: Vec<f64>,
}

impl Standardizer {
    /// Returns the standardizer of these.
    ///
    /// # Shapes
    /// Both `[width]`; standard deviations above 0.
    pub fn new(mean: Vec<f64>, std: Vec<f64>) -> Self {
        Self { mean, std }
    }

    /// Returns the mean of each number.
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// Returns the standard deviation of each number, or its floor.
    pub fn std(&self) -> &[f64] {
        &self.std
    }

    /// Normalises rows in place.
    ///
    /// # Shapes
    /// `[N, width]`, row after row.
    pub fn normalize(&self, rows: &mut [f64]) {
        for row in rows.chunks_exact_mut(self.mean.len()) {
            for ((x, m), s) in row.iter_mut().zip(&self.mean).zip(&self.std) {
                *x = (*x - m) / s;
            }
        }
    }

    /// Returns normalised rows to their own units, in place.
    ///
    /// # Shapes
    /// `[N, width]`, row after row.
    pub fn denormalize(&self, rows: &mut [f64]) {
        for row in rows.chunks_exact_mut(self.mean.len()) {
            for ((x, m), s) in row.iter_mut().zip(&self.mean).zip(&self.std) {
                *x = *x * s + m;
            }
        }
    }

    /// Saves `{name}.mean` and `{name}.spread`.
    pub(super) fn save_into(&self, checkpoint: &mut Checkpoint, name: &str) -> Result<(), CheckpointError> {
        checkpoint.put_f64(&format!("{name}.mean"), &[self.mean.len()], self.mean.clone())?;
        checkpoint.put_f64(&format!("{name}.spread"), &[self.std.len()], self.std.clone())
    }

    pub(super) fn load_from(checkpoint: &Checkpoint, name: &str, width: usize) -> Result<Self, CheckpointError> {
        let numbers = |what: &str| checkpoint.f64s(&format!("{name}.{what}"), &[width]);
        Ok(Self { mean: numbers("mean")?, std: numbers("spread")? })
    }
}

/// Sums over rows on the way to their mean and standard deviation, one pass, without cancellation (Welford 1962).
#[derive(Debug, Clone)]
pub struct Moments {
    mean: Vec<f64>,
    square: Vec<f64>,
    count: f64,
}

impl Moments {
    /// Returns the moments of no rows of `width` numbers.
    pub fn new(width: usize) -> Self {
        Self { mean: vec![0.0; width], square: vec![0.0; width], count: 0.0 }
    }

    /// Adds a row.
    pub fn add(&mut self, row: impl IntoIterator<Item = f64>) {
        self.count += 1.0;
        for ((m, s), x) in self.mean.iter_mut().zip(&mut self.square).zip(row) {
            let delta = x - *m;
            *m += delta / self.count;
            *s += delta * (x - *m);
        }
    }

    /// Returns the mean and standard deviation of each number.
    pub fn finish(self) -> (Vec<f64>, Vec<f64>) {
        let count = f64::max(self.count, 1.0);
        (self.mean, self.square.into_iter().map(|s| (s / count).sqrt()).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_standardized_as_by_hand_and_come_back() {
        let mut moments = Moments::new(2);
        for row in [[1.0, 1e9], [2.0, 1e9 + 3.0], [6.0, 1e9 + 6.0]] {
            moments.add(row);
        }
        let (mean, std) = moments.finish();
        assert_eq!(mean, [3.0, 1e9 + 3.0]);
        assert!((std[0] - (14.0_f64 / 3.0).sqrt()).abs() < 1e-12 && (std[1] - 6.0_f64.sqrt()).abs() < 1e-9);
        let standardizer = Standardizer::new(vec![3.0, -1.0], vec![2.0, 0.5]);
        let mut rows = [5.0, -1.0, 3.0, 0.0];
        standardizer.normalize(&mut rows);
        assert_eq!(rows, [1.0, 0.0, 0.0, 2.0]);
        standardizer.denormalize(&mut rows);
        assert_eq!(rows, [5.0, -1.0, 3.0, 0.0]);
    }
}
