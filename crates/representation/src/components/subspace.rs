//! Principal components by subspace iteration (Halko, Martinsson and Tropp 2011, algorithm 4.4): rows are gone through as often as there
//! are iterations and never held all at once, so the data set may be of any size.

use lifelike_checkpoint::Checkpoint;
use lifelike_checkpoint::rng::stream;
use lifelike_nn::rows::{PackedWeight, weight_gradient};
use nalgebra::DMatrix;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use super::Components;
use crate::{FromInput, RepresentationError};

/// Directions beside those that are wanted: with them the iteration converges by a gap that is further down the spectrum.
const MORE: usize = 16;
/// Rows that a core takes at a time.
const PART: usize = 128;
/// Rows that are held at a time.
const READ: usize = 1024;
/// Rows that are gone through at most, evenly spread: windows of neighbouring frames are next to equal.
const MOST: usize = 50_000;

/// Rows of one size that can be gone through more than once.
pub trait Rows {
    /// Returns how many there are.
    fn len(&self) -> usize;

    /// Returns whether there are none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns some of them, one after another.
    ///
    /// # Errors
    /// Rows that cannot be made.
    fn gather(&self, rows: &[usize]) -> Result<Vec<f32>, RepresentationError>;
}

/// The rows that are gone through.
fn sample(data: &impl Rows) -> Vec<usize> {
    (0..data.len()).step_by(data.len().div_ceil(MOST).max(1)).collect()
}

/// A subspace on its way to that of the largest variance.
#[derive(Debug, Clone)]
pub struct Subspace {
    mean: Vec<f32>,
    /// Mean squared distance of rows to their mean.
    variance: f64,
    /// Orthonormal columns that the next iteration begins with: `[size, k + more]`.
    basis: DMatrix<f64>,
    /// Components by the last iteration: unit rows, and the variance along each.
    directions: Vec<f32>,
    variances: Vec<f64>,
}

impl Subspace {
    /// Begins with random directions about the mean of rows of `size` numbers.
    ///
    /// # Errors
    /// More components than rows, or than numbers in one.
    pub fn new(data: &impl Rows, latent: usize, size: usize, seed: u64) -> Result<Self, RepresentationError> {
        let most = size.min(data.len());
        if latent > most {
            let expected = format!("at most {most}: {} windows of {size} numbers", data.len());
            return Err(RepresentationError::mismatch("latent", expected, latent));
        }
        let rows = sample(data);
        let (mut sum, mut squares) = (vec![0.0; size], 0.0);
        for part in rows.chunks(READ) {
            for row in data.gather(part)?.chunks_exact(size) {
                sum.iter_mut().zip(row).for_each(|(sum, x)| *sum += f64::from(*x));
                squares += row.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>();
            }
        }
        let count = rows.len() as f64;
        let mean: Vec<f64> = sum.into_iter().map(|x| x / count).collect();
        let mut rng = stream(seed, "prior.pca", 0, 0);
        let basis = DMatrix::from_fn(size, (latent + MORE).min(size), |_, _| StandardNormal.sample(&mut rng));
        Ok(Self {
            variance: squares / count - mean.iter().map(|x| x * x).sum::<f64>(),
            mean: mean.into_iter().map(|x| x as f32).collect(),
            basis: basis.qr().q(),
            directions: vec![0.0; latent * size],
            variances: vec![0.0; latent],
        })
    }

    /// One iteration: the covariance times the basis, the components in it, and a new orthonormal basis. Returns the part of the
    /// variance that the components hold.
    ///
    /// # Errors
    /// Rows that cannot be made.
    pub fn iterate(&mut self, data: &impl Rows) -> Result<f64, RepresentationError> {
        let ((size, columns), rows) = (self.basis.shape(), sample(data));
        // nalgebra's columns one after another are the rows of the transpose.
        let basis: Vec<f32> = self.basis.transpose().as_slice().iter().map(|x| *x as f32).collect();
        let basis = PackedWeight::new(&basis, [size, columns]);
        let mut image = DMatrix::<f64>::zeros(size, columns);
        let product = |rows: &[f32]| {
            let mut rows = rows.to_vec();
            rows.chunks_exact_mut(size).for_each(|row| row.iter_mut().zip(&self.mean).for_each(|(x, mean)| *x -= mean));
            let codes = basis.forward(&rows, &[]);
            let mut sums = vec![0.0; columns * size];
            weight_gradient(&codes, &rows, [columns, size], &mut sums);
            sums
        };
        for part in rows.chunks(READ) {
            let x = data.gather(part)?;
            let products: Vec<Vec<f32>> = x.par_chunks(PART * size).map(product).collect();
            for sums in products {
                image.as_mut_slice().iter_mut().zip(sums).for_each(|(sum, x)| *sum += f64::from(x));
            }
        }
        image /= rows.len() as f64;
        let within = self.basis.transpose() * &image;
        let eigen = ((&within + within.transpose()) * 0.5).symmetric_eigen();
        let mut order: Vec<usize> = (0..columns).collect();
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
        order.truncate(self.variances.len());
        let rotated = &self.basis * eigen.eigenvectors.select_columns(&order);
        self.directions = rotated.as_slice().iter().map(|x| *x as f32).collect();
        self.variances = order.iter().map(|i| eigen.eigenvalues[*i].max(0.0)).collect();
        self.basis = image.qr().q();
        Ok(self.variances.iter().sum::<f64>() / self.variance.max(f64::MIN_POSITIVE))
    }

    /// Returns the components by the last iteration.
    pub fn components(&self) -> Components {
        let deviations: Vec<f64> = self.variances.iter().map(|v| v.sqrt()).collect();
        Components::new(self.mean.clone(), &self.directions, &deviations)
    }

    /// Puts in what an iteration changes.
    pub fn save_into(&self, checkpoint: &mut Checkpoint) -> Result<(), RepresentationError> {
        let (size, columns) = self.basis.shape();
        checkpoint.put_f64("subspace.basis", &[columns, size], self.basis.as_slice().to_vec())?;
        checkpoint.put_f32("subspace.directions", &[self.variances.len(), size], self.directions.clone())?;
        Ok(checkpoint.put_f64("subspace.variances", &[self.variances.len()], self.variances.clone())?)
    }

    /// Takes what [`Self::save_into`] wrote of a subspace of the same data.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), RepresentationError> {
        let ((size, columns), latent) = (self.basis.shape(), self.variances.len());
        self.basis = DMatrix::from_vec(size, columns, checkpoint.f64s("subspace.basis", &[columns, size])?);
        self.directions = checkpoint.f32s("subspace.directions", &[latent, size])?;
        self.variances = checkpoint.f64s("subspace.variances", &[latent])?;
        Ok(())
    }
}
