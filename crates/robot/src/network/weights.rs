//! Named arrays that a network is read from.

use lifelike_checkpoint::{Checkpoint, CheckpointError};

/// Arrays of a file under a prefix. Every array is read with the exact shape that is asked for. No size of a header is
/// believed that the arrays do not show.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Weights<'a> {
    file: &'a Checkpoint,
    prefix: &'a str,
}

impl<'a> Weights<'a> {
    pub(crate) fn under(file: &'a Checkpoint, prefix: &'a str) -> Self {
        Self { file, prefix }
    }

    pub(crate) fn f32s(&self, name: &str, shape: &[usize]) -> Result<Vec<f32>, CheckpointError> {
        self.file.f32s(&self.name(name), shape)
    }

    pub(crate) fn f64s(&self, name: &str, shape: &[usize]) -> Result<Vec<f64>, CheckpointError> {
        self.file.f64s(&self.name(name), shape)
    }

    fn name(&self, name: &str) -> String {
        format!("{}.{name}", self.prefix)
    }
}
