//! FID: the Fréchet distance of two sets of embeddings, each taken as a normal distribution (Heusel et al. 2017).

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::embeddings::Embeddings;
use crate::{FromInput, GenerationError};

/// Mean and covariance of embeddings.
#[derive(Debug, Clone, PartialEq)]
pub struct Gaussian {
    mean: DVector<f64>,
    covariance: DMatrix<f64>,
}

impl Gaussian {
    /// Returns the moments of embeddings; the covariance is the unbiased one.
    ///
    /// # Errors
    /// [`GenerationError::Input`] for fewer than two rows.
    pub fn of(embeddings: &Embeddings) -> Result<Self, GenerationError> {
        embeddings.fits(embeddings, 2)?;
        let (n, width) = (embeddings.len(), embeddings.width());
        let mut rows = DMatrix::from_fn(n, width, |i, j| f64::from(embeddings.row(i)[j]));
        let mean = rows.row_mean();
        rows.row_iter_mut().for_each(|mut row| row -= &mean);
        let covariance = rows.tr_mul(&rows) / (n - 1) as f64;
        Ok(Self { mean: mean.transpose(), covariance })
    }
}

/// Returns |μ₁ − μ₂|² + tr(C₁ + C₂ − 2 (C₁^½ C₂ C₁^½)^½).
///
/// The root is that of a symmetric matrix, so eigenvalues that rounding made negative are zero and no complex number
/// appears: fewer embeddings than numbers in one are allowed (and bias the distance upwards).
///
/// # Errors
/// [`GenerationError::Input`] for embeddings of different widths.
pub fn frechet_distance(a: &Gaussian, b: &Gaussian) -> Result<f64, GenerationError> {
    if a.mean.len() != b.mean.len() {
        return Err(GenerationError::mismatch("width of embeddings", a.mean.len(), b.mean.len()));
    }
    let root = root(&a.covariance);
    let product = &root * &b.covariance * &root;
    // Symmetric up to rounding; the eigenvalues of what is exactly symmetric are real.
    let symmetric = (&product + product.transpose()) * 0.5;
    let trace: f64 = symmetric.symmetric_eigenvalues().iter().map(|value| value.max(0.0).sqrt()).sum();
    let apart = (&a.mean - &b.mean).norm_squared();
    Ok((apart + a.covariance.trace() + b.covariance.trace() - 2.0 * trace).max(0.0))
}

/// Returns the symmetric root of a symmetric matrix without negative eigenvalues.
fn root(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let eigen = SymmetricEigen::new(matrix.clone());
    let roots = DMatrix::from_diagonal(&eigen.eigenvalues.map(|value| value.max(0.0).sqrt()));
    &eigen.eigenvectors * roots * eigen.eigenvectors.transpose()
}
