//! Windows of rows, without copies: a motion whose ends are repeated is one array in which every window lies.

use crate::representation::{FeatureMatrix, Standardizer};
use crate::{FromInput, GenerationError};

/// Standardized rows of one motion; before the first and after the last stand `radius` copies of it.
#[derive(Debug, Clone, PartialEq)]
pub struct PaddedRows {
    rows: Vec<f32>,
    n: usize,
    width: usize,
    radius: usize,
}

impl PaddedRows {
    /// Standardizes rows and repeats their ends.
    ///
    /// # Errors
    /// [`GenerationError::Input`] for rows of another width, or none.
    pub fn new(motion: &FeatureMatrix, standardizer: &Standardizer, radius: usize) -> Result<Self, GenerationError> {
        let width = standardizer.mean.len();
        if motion.width != width || motion.n == 0 {
            let got = format!("{} x {}", motion.n, motion.width);
            return Err(GenerationError::mismatch("rows for the critic", format!("at least one row of {width}"), got));
        }
        let n = motion.n;
        let source = (0..n + 2 * radius).map(|i| i.saturating_sub(radius).min(n - 1));
        let mut rows: Vec<f32> = source.flat_map(|i| motion.row(i)).copied().collect();
        standardizer.standardize(&mut rows);
        Ok(Self { rows, n, width, radius })
    }

    /// Returns the number of rows, and of windows.
    pub fn len(&self) -> usize {
        self.n
    }

    /// Returns the length of a window, `(2 radius + 1) width`.
    pub fn window_size(&self) -> usize {
        (2 * self.radius + 1) * self.width
    }

    /// Returns the window around a row.
    pub fn window(&self, at: usize) -> &[f32] {
        &self.rows[at * self.width..][..self.window_size()]
    }

    /// Returns the gradient by the motion in its own units, given that by the padded standardized rows: a repeated row has
    /// the sum of its copies.
    pub fn fold(&self, by_padded: &[f32], standardizer: &Standardizer) -> Vec<f32> {
        let mut by = vec![0.0; self.n * self.width];
        for (i, copy) in by_padded.chunks_exact(self.width).enumerate() {
            let row = i.saturating_sub(self.radius).min(self.n - 1);
            let to = &mut by[row * self.width..][..self.width];
            for ((to, from), std) in to.iter_mut().zip(copy).zip(&standardizer.std) {
                *to += from / std;
            }
        }
        by
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn standardizer() -> Standardizer {
        Standardizer { mean: vec![1.0, 0.0], std: vec![2.0, 0.5] }
    }

    #[test]
    fn windows_beyond_the_ends_repeat_them() {
        let motion = FeatureMatrix::new(vec![1.0, 1.0, 3.0, 2.0, 5.0, 3.0], 2).unwrap();
        let padded = PaddedRows::new(&motion, &standardizer(), 2).unwrap();
        assert_eq!((padded.len(), padded.window_size()), (3, 10));
        assert_eq!(padded.window(0), [0.0, 2.0, 0.0, 2.0, 0.0, 2.0, 1.0, 4.0, 2.0, 6.0]);
        assert_eq!(padded.window(2), [0.0, 2.0, 1.0, 4.0, 2.0, 6.0, 2.0, 6.0, 2.0, 6.0]);
        // Copies count for their row, and standard deviations divide.
        assert_eq!(padded.fold(&[1.0; 14], &standardizer()), [1.5, 6.0, 0.5, 2.0, 1.5, 6.0]);
    }

    #[test]
    fn rows_of_another_width_are_refused() {
        let motion = FeatureMatrix::new(vec![0.0; 6], 3).unwrap();
        let error = PaddedRows::new(&motion, &standardizer(), 2).unwrap_err().to_string();
        assert!(error.contains("rows of 2") || error.contains("row of 2"), "{error}");
        let none = FeatureMatrix::new(vec![], 2).unwrap();
        assert!(PaddedRows::new(&none, &standardizer(), 2).is_err());
    }
}
