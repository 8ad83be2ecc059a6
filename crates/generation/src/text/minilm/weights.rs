//! Arrays of somebody else's safetensors file.

use std::path::Path;

use safetensors::{Dtype, SafeTensors};

use crate::GenerationError;

/// Reads a file of a text model.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, GenerationError> {
    std::fs::read(path)
        .map_err(|e| GenerationError::text_model(path, format!("{e}; fetch it with `cargo xtask fetch minilm`")))
}

/// The arrays of a file.
pub(super) struct Weights<'a> {
    path: &'a Path,
    arrays: SafeTensors<'a>,
}

impl<'a> Weights<'a> {
    pub(super) fn new(path: &'a Path, bytes: &'a [u8]) -> Result<Self, GenerationError> {
        let arrays = SafeTensors::deserialize(bytes).map_err(|e| GenerationError::text_model(path, e))?;
        Ok(Self { path, arrays })
    }

    /// Returns the numbers of an array and its number of rows; `width` is that of a row.
    pub(super) fn rows(&self, name: &str, width: usize) -> Result<(Vec<f32>, usize), GenerationError> {
        let array = self.arrays.tensor(name).map_err(|e| GenerationError::text_model(self.path, e))?;
        let wrong = |expected: String, got: String| {
            Err(GenerationError::text_model(self.path, format!("{name}: expected {expected}, got {got}")))
        };
        if array.dtype() != Dtype::F32 {
            return wrong("F32".into(), format!("{:?}", array.dtype()));
        }
        let &[rows, columns] = array.shape() else {
            return wrong("two dimensions".into(), format!("shape {:?}", array.shape()));
        };
        if columns != width {
            return wrong(format!("rows of {width}"), format!("shape {:?}", array.shape()));
        }
        Ok((numbers(array.data()), rows))
    }

    /// Returns the numbers of a vector of this length.
    pub(super) fn vector(&self, name: &str, length: usize) -> Result<Vec<f32>, GenerationError> {
        let array = self.arrays.tensor(name).map_err(|e| GenerationError::text_model(self.path, e))?;
        if array.dtype() != Dtype::F32 || array.shape() != [length] {
            let got = format!("{name}: expected F32 [{length}], got {:?} {:?}", array.dtype(), array.shape());
            return Err(GenerationError::text_model(self.path, got));
        }
        Ok(numbers(array.data()))
    }

    /// Returns a PyTorch weight `[outputs, inputs]` as `[inputs, outputs]`.
    pub(super) fn transposed(&self, name: &str, inputs: usize, outputs: usize) -> Result<Vec<f32>, GenerationError> {
        let (weight, rows) = self.rows(name, inputs)?;
        if rows != outputs {
            let why = format!("{name}: expected {outputs} rows, got {rows}");
            return Err(GenerationError::text_model(self.path, why));
        }
        let mut turned = vec![0.0; weight.len()];
        for (o, row) in weight.chunks_exact(inputs).enumerate() {
            for (i, x) in row.iter().enumerate() {
                turned[i * outputs + o] = *x;
            }
        }
        Ok(turned)
    }
}

fn numbers(bytes: &[u8]) -> Vec<f32> {
    bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
}
