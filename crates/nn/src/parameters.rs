//! The parameters of one network: names, shapes and values, all in one row of numbers.

use std::ops::Range;
use std::sync::Arc;

use lifelike_checkpoint::{Checkpoint, CheckpointError};

use crate::adam::{Adam, Descent, Stepped};
use crate::rows::Layout;

/// Named parameters. Networks pack them into kernels; optimizers, averages and files go by the row.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    layout: Arc<Layout>,
    values: Vec<f32>,
}

impl Parameters {
    /// Returns the parameters of a layout.
    ///
    /// # Panics
    /// `values` are not as many as the layout has places.
    pub fn new(layout: Layout, values: Vec<f32>) -> Self {
        assert_eq!(values.len(), layout.len(), "values of a layout");
        Self { layout: Arc::new(layout), values }
    }

    /// Returns where each parameter stands.
    pub fn layout(&self) -> &Arc<Layout> {
        &self.layout
    }

    /// Returns all values.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Returns all values, to be changed.
    pub fn values_mut(&mut self) -> &mut [f32] {
        &mut self.values
    }

    /// Returns how many numbers there are.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Returns whether there are none.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Returns the place of a parameter; an empty one for a name that there is not.
    pub fn range(&self, name: &str) -> Range<usize> {
        self.layout.range(name)
    }

    /// Returns the values of a parameter.
    pub fn get(&self, name: &str) -> &[f32] {
        &self.values[self.range(name)]
    }

    /// Returns the values of a parameter, to be changed.
    pub fn get_mut(&mut self, name: &str) -> &mut [f32] {
        let range = self.range(name);
        &mut self.values[range]
    }

    /// Takes a step of the optimizer, unless the gradient is not finite.
    ///
    /// # Panics
    /// As [`Adam::step`].
    pub fn step(&mut self, optimizer: &mut Adam, descent: Descent<'_>) -> Stepped {
        optimizer.step(&self.layout, &mut self.values, descent)
    }

    /// Adds them to a checkpoint as `prefix.NAME`.
    ///
    /// # Errors
    /// A name is taken.
    pub fn save_into(&self, checkpoint: &mut Checkpoint, prefix: &str) -> Result<(), CheckpointError> {
        self.layout.save_into(checkpoint, prefix, &self.values)
    }

    /// Returns parameters of the same layout, with the values saved as `prefix.NAME`.
    ///
    /// # Errors
    /// As [`Layout::load_from`].
    pub fn load_from(&self, checkpoint: &Checkpoint, prefix: &str) -> Result<Self, CheckpointError> {
        Ok(Self { layout: Arc::clone(&self.layout), values: self.layout.load_from(checkpoint, prefix)? })
    }
}

/// Collects the parameters of a network, one after another.
#[derive(Debug, Default)]
pub struct ParameterList {
    named: Vec<(String, Vec<usize>)>,
    values: Vec<f32>,
}

impl ParameterList {
    /// Adds a parameter with its initial values, row-major.
    ///
    /// # Panics
    /// The values do not fill the shape.
    pub fn add(&mut self, name: impl Into<String>, shape: &[usize], values: Vec<f32>) {
        let name = name.into();
        assert_eq!(values.len(), shape.iter().product::<usize>(), "values of {name}");
        self.named.push((name, shape.to_vec()));
        self.values.extend(values);
    }

    /// Returns the parameters.
    pub fn finish(self) -> Parameters {
        Parameters::new(Layout::of_shapes(self.named), self.values)
    }
}
