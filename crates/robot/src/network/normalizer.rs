//! Normalisation of observations by the mean and variance that training has seen.

use lifelike_checkpoint::{Checkpoint, CheckpointError};

use super::Weights;

/// Variance below which a number is treated as constant and only centred.
const MIN_VARIANCE: f64 = 1e-8;

/// (x − mean) / deviation, clipped.
#[derive(Debug, Clone, PartialEq)]
pub struct Normalizer {
    mean: Vec<f32>,
    inverse: Vec<f32>,
    clip: f32,
    /// As the file has it: mean, variance, settings.
    stored: [Vec<f64>; 3],
}

impl Normalizer {
    /// Reads a normaliser for rows of `size` numbers.
    ///
    /// # Errors
    /// It is not there, or is for rows of another size.
    pub fn load(file: &Checkpoint, prefix: &str, size: usize) -> Result<Self, CheckpointError> {
        let from = Weights::under(file, prefix);
        let stored = [from.f64s("mean", &[size])?, from.f64s("variance", &[size])?, from.f64s("settings", &[4])?];
        let inverse = |v: &f64| if *v > MIN_VARIANCE { (1.0 / v.sqrt()) as f32 } else { 1.0 };
        Ok(Self {
            mean: stored[0].iter().map(|m| *m as f32).collect(),
            inverse: stored[1].iter().map(inverse).collect(),
            // The file's third setting; a clip that is no width would be a panic at every step.
            clip: match stored[2][2] as f32 {
                clip if clip >= 0.0 => clip,
                _ => f32::INFINITY,
            },
            stored,
        })
    }

    /// Writes it as [`Self::load`] reads it.
    ///
    /// # Errors
    /// The names are taken.
    pub fn save_into(&self, file: &mut Checkpoint, prefix: &str) -> Result<(), CheckpointError> {
        for (name, values) in ["mean", "variance", "settings"].into_iter().zip(&self.stored) {
            file.put_f64(&format!("{prefix}.{name}"), &[values.len()], values.clone())?;
        }
        Ok(())
    }

    /// Numbers of a row.
    pub fn size(&self) -> usize {
        self.mean.len()
    }

    /// Mean of each number, `[size]`.
    pub fn mean(&self) -> &[f32] {
        &self.mean
    }

    /// Inverse of the standard deviation of each number, `[size]`.
    pub fn inverse_deviation(&self) -> &[f32] {
        &self.inverse
    }

    /// Normalises rows in place.
    ///
    /// # Shapes
    /// `rows: [N, size]`.
    pub fn normalize(&self, rows: &mut [f32]) {
        for row in rows.chunks_exact_mut(self.size().max(1)) {
            for ((x, m), s) in row.iter_mut().zip(&self.mean).zip(&self.inverse) {
                *x = ((*x - m) * s).clamp(-self.clip, self.clip);
            }
        }
    }
}
