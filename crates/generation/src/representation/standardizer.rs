//! Columns of different units made comparable.

use lifelike_representation::standardizer::Moments;

use super::FeatureMatrix;
use crate::{FromInput, GenerationError};

/// Mean and standard deviation of each column.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Standardizer {
    /// Mean of each column.
    pub mean: Vec<f32>,
    /// Standard deviation of each column, at least the floor.
    pub std: Vec<f32>,
}

impl Standardizer {
    /// Floor of standard deviations (SI units of the column): a joint that hardly moves is not blown up to noise.
    pub const FLOOR: f64 = 0.02;

    /// Returns the statistics of all rows together.
    ///
    /// # Errors
    /// [`GenerationError::Input`] for no rows, or rows of different widths.
    pub fn of<'a>(motions: impl IntoIterator<Item = &'a FeatureMatrix>, floor: f64) -> Result<Self, GenerationError> {
        let mut motions = motions.into_iter().peekable();
        let width = motions.peek().map_or(0, |first| first.width);
        let (mut moments, mut rows) = (Moments::new(width), 0);
        for motion in motions {
            if motion.width != width {
                return Err(GenerationError::mismatch("width of a motion", width, motion.width));
            }
            rows += motion.n;
            motion.rows.chunks_exact(width.max(1)).for_each(|row| moments.add(row.iter().map(|x| f64::from(*x))));
        }
        if rows == 0 {
            return Err(GenerationError::mismatch("rows to standardize", "at least one", 0));
        }
        let (mean, std) = moments.finish();
        let single = |numbers: Vec<f64>| numbers.into_iter().map(|x| x as f32).collect();
        Ok(Self { mean: single(mean), std: single(std.into_iter().map(|s| s.max(floor)).collect()) })
    }

    /// Standardizes rows in place, `[n, width]`.
    pub fn standardize(&self, rows: &mut [f32]) {
        for row in rows.chunks_exact_mut(self.mean.len().max(1)) {
            for ((x, mean), std) in row.iter_mut().zip(&self.mean).zip(&self.std) {
                *x = (*x - mean) / std;
            }
        }
    }

    /// Returns standardized rows to their units in place, `[n, width]`.
    pub fn restore(&self, rows: &mut [f32]) {
        for row in rows.chunks_exact_mut(self.mean.len().max(1)) {
            for ((x, mean), std) in row.iter_mut().zip(&self.mean).zip(&self.std) {
                *x = *x * std + mean;
            }
        }
    }
}
