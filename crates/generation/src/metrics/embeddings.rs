//! Rows of numbers that stand for motions or sentences.

use crate::{FromInput, GenerationError};

/// Embeddings of several motions or sentences, `[n, width]`, row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct Embeddings {
    width: usize,
    numbers: Vec<f32>,
}

impl Embeddings {
    /// Returns embeddings of this width.
    ///
    /// # Errors
    /// [`GenerationError::Input`] for numbers that make no whole rows, or that are not all finite.
    pub fn new(numbers: Vec<f32>, width: usize) -> Result<Self, GenerationError> {
        if width == 0 || !numbers.len().is_multiple_of(width) {
            let expected = format!("rows of {width}");
            return Err(GenerationError::mismatch("numbers of embeddings", expected, numbers.len()));
        }
        if let Some(at) = numbers.iter().position(|x| !x.is_finite()) {
            let what = format!("embedding {}, number {}", at / width, at % width);
            return Err(GenerationError::mismatch(what, "a finite number", numbers[at]));
        }
        Ok(Self { width, numbers })
    }

    /// Returns the number of rows.
    pub fn len(&self) -> usize {
        self.numbers.len() / self.width
    }

    /// Returns whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.numbers.is_empty()
    }

    /// Returns the length of a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Returns one row.
    pub fn row(&self, at: usize) -> &[f32] {
        &self.numbers[at * self.width..(at + 1) * self.width]
    }

    /// Returns all rows.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[f32]> {
        self.numbers.chunks_exact(self.width)
    }

    /// Checks that others have the same width, and at least as many rows as this asks for.
    pub(super) fn fits(&self, other: &Self, rows: usize) -> Result<(), GenerationError> {
        if self.width != other.width {
            return Err(GenerationError::mismatch("width of embeddings", self.width, other.width));
        }
        match self.len().min(other.len()) {
            few if few < rows => Err(GenerationError::mismatch("embeddings", format!("at least {rows}"), few)),
            _ => Ok(()),
        }
    }
}

/// Returns the Euclidean distance of two rows.
pub(super) fn distance(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum::<f64>().sqrt()
}
