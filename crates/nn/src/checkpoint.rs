//! Parameters of burn modules to checkpoints and back, by name; the file itself is [`lifelike_checkpoint`].

use burn::module::{Module, ModuleMapper, ModuleVisitor, Param};
use burn::tensor::{Device, Tensor, TensorData};

use lifelike_checkpoint::{Checkpoint, CheckpointError};

use crate::names::{Path, parameters};

/// Tensors and modules in a [`Checkpoint`].
pub trait ModuleCheckpoint {
    /// Adds a tensor's exact bits as f32.
    ///
    /// # Errors
    /// Tensor data could not be read from the device; the name is taken.
    fn put_tensor<const D: usize>(&mut self, name: &str, tensor: &Tensor<D>) -> Result<(), CheckpointError>;

    /// Returns a tensor of exactly this shape.
    ///
    /// # Errors
    /// There is none of this name and shape.
    fn tensor<const D: usize>(
        &self,
        name: &str,
        shape: [usize; D],
        device: &Device,
    ) -> Result<Tensor<D>, CheckpointError>;

    /// Adds every float parameter of a module as `prefix.NAME`.
    ///
    /// # Errors
    /// As [`Self::put_tensor`].
    fn put_module<M: Module>(&mut self, prefix: &str, module: &M) -> Result<(), CheckpointError>;

    /// Gives a module of the same structure the parameters stored under `prefix`, bit for bit.
    ///
    /// # Errors
    /// Every missing name at once; an entry under `prefix` that the module does not know; a parameter of another shape.
    fn load_module<M: Module>(&self, prefix: &str, module: M) -> Result<M, CheckpointError>;
}

impl ModuleCheckpoint for Checkpoint {
    fn put_tensor<const D: usize>(&mut self, name: &str, tensor: &Tensor<D>) -> Result<(), CheckpointError> {
        let values = tensor
            .try_to_vec_as::<f32>()
            .map_err(|e| CheckpointError::Device { name: name.to_owned(), why: e.to_string() })?;
        self.put_f32(name, &tensor.dims(), values)
    }

    fn tensor<const D: usize>(
        &self,
        name: &str,
        shape: [usize; D],
        device: &Device,
    ) -> Result<Tensor<D>, CheckpointError> {
        Ok(Tensor::from_data(TensorData::new(self.f32s(name, &shape)?, shape), device))
    }

    fn put_module<M: Module>(&mut self, prefix: &str, module: &M) -> Result<(), CheckpointError> {
        let mut visitor = Put { path: Path::default(), prefix, checkpoint: self, result: Ok(()) };
        module.visit(&mut visitor);
        visitor.result
    }

    fn load_module<M: Module>(&self, prefix: &str, module: M) -> Result<M, CheckpointError> {
        let wanted: Vec<String> = parameters(&module).into_iter().map(|(n, _)| format!("{prefix}.{n}")).collect();
        let missing: Vec<String> = wanted.iter().filter(|n| !self.contains(n)).cloned().collect();
        if !missing.is_empty() {
            return Err(CheckpointError::Missing { path: self.origin().to_owned(), names: missing });
        }
        let under = format!("{prefix}.");
        let unexpected: Vec<String> =
            self.entries().keys().filter(|n| n.starts_with(&under) && !wanted.contains(n)).cloned().collect();
        if !unexpected.is_empty() {
            return Err(CheckpointError::Unexpected { path: self.origin().to_owned(), names: unexpected });
        }
        let mut mapper = Load { path: Path::default(), prefix, checkpoint: self, failure: None };
        let module = module.map(&mut mapper);
        match mapper.failure {
            Some(e) => Err(e),
            None => Ok(module),
        }
    }
}

struct Put<'a> {
    path: Path,
    prefix: &'a str,
    checkpoint: &'a mut Checkpoint,
    result: Result<(), CheckpointError>,
}

impl ModuleVisitor for Put<'_> {
    fn enter_module(&mut self, name: &str, _: &str) {
        self.path.enter(name);
    }
    fn exit_module(&mut self, _: &str, _: &str) {
        self.path.exit();
    }
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        if self.result.is_ok() {
            let name = format!("{}.{}", self.prefix, self.path.name());
            self.result = self.checkpoint.put_tensor(&name, &param.val());
        }
    }
}

struct Load<'a> {
    path: Path,
    prefix: &'a str,
    checkpoint: &'a Checkpoint,
    failure: Option<CheckpointError>,
}

impl ModuleMapper for Load<'_> {
    fn enter_module(&mut self, name: &str, _: &str) {
        self.path.enter(name);
    }
    fn exit_module(&mut self, _: &str, _: &str) {
        self.path.exit();
    }
    fn map_float<const D: usize>(&mut self, param: Param<Tensor<D>>) -> Param<Tensor<D>> {
        let name = format!("{}.{}", self.prefix, self.path.name());
        let shape: [usize; D] = param.val().dims();
        match self.checkpoint.f32s(&name, &shape) {
            Ok(values) => param.map(|old| {
                let new = Tensor::from_data(TensorData::new(values, shape), &old.device());
                new.set_require_grad(old.is_require_grad())
            }),
            Err(e) => {
                self.failure.get_or_insert(e);
                param
            }
        }
    }
}
