//! Tensor data as plain numbers.

use std::ops::Range;

use burn::module::{Module, ModuleVisitor, Param};
use burn::tensor::Tensor;

use crate::names::Path;

/// Tensor data that could not be read from its device.
#[derive(Debug, thiserror::Error)]
#[error("tensor data could not be read from the device: {0}")]
pub struct Unreadable(String);

/// Reads a tensor's data, row-major.
///
/// # Errors
/// Tensor data that cannot be read from the device.
pub fn read<const D: usize>(tensor: Tensor<D>) -> Result<Vec<f32>, Unreadable> {
    tensor.try_into_vec_as::<f32>().map_err(|e| Unreadable(e.to_string()))
}

/// A module's parameters in one row of numbers, in the module's own order.
#[derive(Debug, Clone, Default)]
pub(crate) struct Row {
    /// Name and place of each.
    pub(crate) places: Vec<(String, Range<usize>)>,
    pub(crate) values: Vec<f32>,
}

impl Row {
    /// Reads all parameters of a module.
    ///
    /// # Errors
    /// Tensor data that cannot be read from the device.
    pub(crate) fn of<M: Module>(module: &M) -> Result<Self, Unreadable> {
        let mut visitor = Collect { path: Path::default(), row: Self::default(), failed: None };
        module.visit(&mut visitor);
        visitor.failed.map_or(Ok(visitor.row), Err)
    }
}

struct Collect {
    path: Path,
    row: Row,
    failed: Option<Unreadable>,
}

impl ModuleVisitor for Collect {
    fn enter_module(&mut self, name: &str, _: &str) {
        self.path.enter(name);
    }
    fn exit_module(&mut self, _: &str, _: &str) {
        self.path.exit();
    }
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        match read(param.val().without_autodiff()) {
            Ok(values) => {
                let first = self.row.values.len();
                self.row.values.extend(values);
                self.row.places.push((self.path.name(), first..self.row.values.len()));
            }
            Err(error) => self.failed = Some(error),
        }
    }
}
