//! Windows, or sequences of another kind, to principal components and back.

use lifelike_checkpoint::Checkpoint;
use lifelike_nn::rows::PackedWeight;
use rayon::prelude::*;

use crate::RepresentationError;

/// The mean row, and directions from it, each as long as the standard deviation of the rows along it.
#[derive(Debug, Clone)]
pub struct Components {
    mean: Vec<f32>,
    /// Orthogonal rows, largest first: `[k, size]`.
    directions: Vec<f32>,
    latent: usize,
}

/// Rows that a core takes at a time.
const PART: usize = 128;

/// Names in files.
const MEAN: &str = "components.mean";
const DIRECTIONS: &str = "components.directions";

impl Components {
    /// `directions` are unit rows; `deviations` is the standard deviation of the data along each.
    pub(super) fn new(mean: Vec<f32>, directions: &[f32], deviations: &[f64]) -> Self {
        let rows = directions.chunks_exact(mean.len()).zip(deviations);
        let directions = rows.flat_map(|(row, s)| row.iter().map(move |x| x * *s as f32)).collect();
        Self { mean, directions, latent: deviations.len() }
    }

    /// Returns the number of components.
    pub fn len(&self) -> usize {
        self.latent
    }

    /// Returns whether there are none: then every row is the mean.
    pub fn is_empty(&self) -> bool {
        self.latent == 0
    }

    /// Returns the mean row.
    pub fn mean(&self) -> &[f32] {
        &self.mean
    }

    /// Returns the first `count` of them alone: the best of that number.
    #[must_use]
    pub fn first(&self, count: usize) -> Self {
        let latent = count.min(self.latent);
        Self { directions: self.directions[..latent * self.mean.len()].to_vec(), latent, mean: self.mean.clone() }
    }

    /// Puts in what [`Self::read`] reads.
    pub(crate) fn save_into(&self, checkpoint: &mut Checkpoint) -> Result<(), RepresentationError> {
        checkpoint.put_f32(MEAN, &[self.mean.len()], self.mean.clone())?;
        Ok(checkpoint.put_f32(DIRECTIONS, &[self.latent, self.mean.len()], self.directions.clone())?)
    }

    /// Reads what [`Self::save_into`] wrote, for rows of `size` numbers.
    pub(crate) fn read(checkpoint: &Checkpoint, latent: usize, size: usize) -> Result<Self, RepresentationError> {
        let mean = checkpoint.f32s(MEAN, &[size])?;
        let directions = checkpoint.f32s(DIRECTIONS, &[latent, size])?;
        Ok(Self { mean, directions, latent })
    }

    /// Returns the components of rows, in standard deviations.
    ///
    /// # Shapes
    /// `[N, size]` to `[N, k]`, row-major.
    pub fn encode(&self, rows: &[f32]) -> Vec<f32> {
        let size = self.mean.len();
        let mut columns = vec![0.0; self.directions.len()];
        for (k, row) in self.directions.chunks_exact(size).enumerate() {
            row.iter().enumerate().for_each(|(i, x)| columns[i * self.latent + k] = *x);
        }
        let columns = PackedWeight::new(&columns, [size, self.latent]);
        let square = |row: &[f32]| row.iter().map(|x| x * x).sum::<f32>().max(f32::MIN_POSITIVE);
        let squares: Vec<f32> = self.directions.chunks_exact(size).map(square).collect();
        // x · row / |row|² is the component in standard deviations.
        let part = |rows: &[f32]| {
            let mut rows = rows.to_vec();
            rows.chunks_exact_mut(size).for_each(|row| row.iter_mut().zip(&self.mean).for_each(|(x, mean)| *x -= mean));
            let mut codes = columns.forward(&rows, &[]);
            codes.iter_mut().zip(squares.iter().cycle()).for_each(|(code, square)| *code /= square);
            codes
        };
        rows.par_chunks(PART * size).map(part).collect::<Vec<_>>().concat()
    }

    /// Returns the rows that components stand for.
    ///
    /// # Shapes
    /// `[N, k]` to `[N, size]`, row-major.
    pub fn decode(&self, codes: &[f32]) -> Vec<f32> {
        let directions = PackedWeight::new(&self.directions, [self.latent, self.mean.len()]);
        let parts = codes.par_chunks((PART * self.latent).max(1)).map(|codes| directions.forward(codes, &self.mean));
        parts.collect::<Vec<_>>().concat()
    }

    /// Returns the gradient by components, from that by the rows of [`Self::decode`].
    pub(crate) fn by_codes(&self, by_rows: &[f32]) -> Vec<f32> {
        PackedWeight::new(&self.directions, [self.latent, self.mean.len()]).by_input(by_rows)
    }
}
