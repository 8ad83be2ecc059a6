//! Gradients of a module's parameters, by name.

use std::collections::BTreeMap;

use burn::module::{Module, ModuleVisitor, Param};
use burn::tensor::{Tensor, TensorData};

use crate::names::Path;
use crate::numbers::{Unreadable, read};

/// The gradient of every parameter that has one, flattened, keyed by the parameter's name.
#[derive(Debug, Clone, Default)]
pub struct Gradients {
    by_name: BTreeMap<String, Tensor<1>>,
}

impl Gradients {
    /// Takes the gradients of `module` out of what `loss.backward()` returned. Parameters the loss does not depend on
    /// have no entry (and an optimizer leaves them and their moments untouched, as PyTorch does for `grad = None`).
    pub fn of<M: Module>(module: &M, mut recorded: burn::tensor::Gradients) -> Self {
        Self::taken_from(module, &mut recorded)
    }

    /// As [`Self::of`], leaving the gradients of other modules in `recorded`.
    pub fn taken_from<M: Module>(module: &M, recorded: &mut burn::tensor::Gradients) -> Self {
        let mut visitor = Take { path: Path::default(), recorded, out: BTreeMap::new() };
        module.visit(&mut visitor);
        Self { by_name: visitor.out }
    }

    /// Adds the gradient of one parameter, flattened, however it was computed.
    pub fn insert(&mut self, name: String, gradient: Tensor<1>) {
        self.by_name.insert(name, gradient);
    }

    /// Lets somebody change the numbers of each gradient, in alphabetical order of their names.
    ///
    /// # Errors
    /// Tensor data that cannot be read from the device.
    pub fn rewrite(&mut self, mut change: impl FnMut(&mut [f32])) -> Result<(), Unreadable> {
        for gradient in self.by_name.values_mut() {
            let device = gradient.device();
            let mut values = read(gradient.clone())?;
            change(&mut values);
            let n = values.len();
            *gradient = Tensor::from_data(TensorData::new(values, [n]), &device);
        }
        Ok(())
    }

    /// Takes in the gradients of other parameters.
    pub fn extend(&mut self, others: Self) {
        self.by_name.extend(others.by_name);
    }

    /// Returns the gradient of one parameter, flattened.
    pub fn get(&self, name: &str) -> Option<&Tensor<1>> {
        self.by_name.get(name)
    }

    /// Removes and returns one parameter's gradient.
    pub(crate) fn take(&mut self, name: &str) -> Option<Tensor<1>> {
        self.by_name.remove(name)
    }

    /// Names in alphabetical order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.by_name.keys().map(String::as_str)
    }

    /// Returns the Euclidean norm over all parameters together. NaN or infinite when any entry is.
    ///
    /// # Errors
    /// Tensor data that cannot be read from the device.
    pub fn norm(&self) -> Result<f64, Unreadable> {
        let squares: Vec<Tensor<1>> = self.by_name.values().map(|g| g.clone().square().sum()).collect();
        if squares.is_empty() {
            return Ok(0.0);
        }
        // Read at once: each reading from a card waits for it.
        Ok(read(Tensor::cat(squares, 0))?.into_iter().map(f64::from).sum::<f64>().sqrt())
    }

    /// Scales all gradients together so that their norm does not exceed `max_norm`; returns the norm before. The factor
    /// is max_norm / (norm + 1e-6), as in PyTorch's `clip_grad_norm_`.
    ///
    /// A non-finite norm leaves the gradients as they are: whoever reads the returned norm must not step with them.
    ///
    /// # Errors
    /// Tensor data that cannot be read from the device.
    pub fn clip_norm(&mut self, max_norm: f64) -> Result<f64, Unreadable> {
        let norm = self.norm()?;
        let factor = max_norm / (norm + 1e-6);
        if norm.is_finite() && factor < 1.0 {
            for g in self.by_name.values_mut() {
                *g = g.clone().mul_scalar(factor);
            }
        }
        Ok(norm)
    }
}

struct Take<'a> {
    path: Path,
    recorded: &'a mut burn::tensor::Gradients,
    out: BTreeMap<String, Tensor<1>>,
}

impl ModuleVisitor for Take<'_> {
    fn enter_module(&mut self, name: &str, _: &str) {
        self.path.enter(name);
    }
    fn exit_module(&mut self, _: &str, _: &str) {
        self.path.exit();
    }
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        if let Some(g) = param.val().grad_remove(self.recorded) {
            let n = g.shape().num_elements();
            self.out.insert(self.path.name(), g.reshape([n]));
        }
    }
}
