//! Principal components of windows: the whole encoder of a prior that is nothing else, or the linear path beside a convolutional one.

use lifelike_checkpoint::{Checkpoint, CheckpointError};

/// Names in files.
const MEAN: &str = "components.mean";
const DIRECTIONS: &str = "components.directions";

/// The mean window, and directions from it, each as long as the standard deviation of the training windows along it.
#[derive(Debug, Clone, PartialEq)]
pub struct ComponentEncoder {
    mean: Vec<f32>,
    /// `[d_z, numbers of a window]`.
    directions: Vec<f32>,
    /// |direction|², `[d_z]`.
    squares: Vec<f32>,
}

impl ComponentEncoder {
    /// Reads the components of windows of `size` numbers.
    ///
    /// # Errors
    /// An array is missing or of another shape.
    pub(crate) fn load(file: &Checkpoint, size: usize, latent: usize) -> Result<Self, CheckpointError> {
        let directions = file.f32s(DIRECTIONS, &[latent, size])?;
        let square = |row: &[f32]| row.iter().map(|x| x * x).sum::<f32>().max(f32::MIN_POSITIVE);
        let squares = directions.chunks_exact(size.max(1)).map(square).collect();
        Ok(Self { mean: file.f32s(MEAN, &[size])?, directions, squares })
    }

    /// Writes the components as [`Self::load`] reads them.
    ///
    /// # Errors
    /// The names are taken.
    pub(crate) fn save_into(&self, file: &mut Checkpoint) -> Result<(), CheckpointError> {
        file.put_f32(MEAN, &[self.mean.len()], self.mean.clone())?;
        file.put_f32(DIRECTIONS, &[self.squares.len(), self.mean.len()], self.directions.clone())
    }

    /// Adds the components of normalised windows, in standard deviations, to codes.
    ///
    /// # Shapes
    /// `windows: [B, numbers]`, `codes: [B, d_z]`.
    pub fn add(&self, windows: &[f32], codes: &mut [f32]) {
        let size = self.mean.len();
        for (window, code) in windows.chunks_exact(size).zip(codes.chunks_exact_mut(self.squares.len())) {
            let directions = self.directions.chunks_exact(size).zip(&self.squares);
            for (z, (direction, square)) in code.iter_mut().zip(directions) {
                *z += component(window, &self.mean, direction) / square;
            }
        }
    }
}

/// (window − mean) · direction, in sixteen sums side by side.
fn component(window: &[f32], mean: &[f32], direction: &[f32]) -> f32 {
    let mut sums = [0.0_f32; 16];
    let [x, m, d] = [window, mean, direction].map(|row| row.as_chunks::<16>());
    for ((x, m), d) in x.0.iter().zip(m.0).zip(d.0) {
        for k in 0..16 {
            sums[k] += (x[k] - m[k]) * d[k];
        }
    }
    let rest: f32 = x.1.iter().zip(m.1).zip(d.1).map(|((x, m), d)| (x - m) * d).sum();
    sums.iter().sum::<f32>() + rest
}
