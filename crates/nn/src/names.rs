//! Names of a module's parameters: field names joined by dots, as PyTorch's `state_dict` does.

use burn::module::{Module, ModuleVisitor, Param};
use burn::tensor::Tensor;

/// The path to the parameter a visitor or mapper stands at.
#[derive(Debug, Default)]
pub(crate) struct Path(Vec<String>);

impl Path {
    pub(crate) fn enter(&mut self, name: &str) {
        self.0.push(name.to_owned());
    }

    pub(crate) fn exit(&mut self) {
        self.0.pop();
    }

    pub(crate) fn name(&self) -> String {
        self.0.join(".")
    }
}

/// Returns the name and shape of every float parameter, in the module's own order.
pub fn parameters<M: Module>(module: &M) -> Vec<(String, Vec<usize>)> {
    struct Collect {
        path: Path,
        out: Vec<(String, Vec<usize>)>,
    }
    impl ModuleVisitor for Collect {
        fn enter_module(&mut self, name: &str, _: &str) {
            self.path.enter(name);
        }
        fn exit_module(&mut self, _: &str, _: &str) {
            self.path.exit();
        }
        fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
            self.out.push((self.path.name(), param.lazy_shape().to_vec()));
        }
    }
    let mut visitor = Collect { path: Path::default(), out: Vec::new() };
    module.visit(&mut visitor);
    visitor.out
}
