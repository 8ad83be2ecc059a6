//! Where each parameter stands in the row of a network's numbers, and in rows of their gradients.

use std::ops::Range;

use burn::module::Module;
use burn::tensor::{Device, Tensor, TensorData};

use crate::gradients::Gradients;
use crate::numbers::{Row, Unreadable};

/// A network's parameters in one row, by name.
#[derive(Debug, Clone)]
pub(super) struct Places(Row);

impl Places {
    pub(super) fn of<M: Module>(network: &M) -> Result<Self, Unreadable> {
        Row::of(network).map(Self)
    }

    /// Returns how many numbers there are.
    pub(super) fn len(&self) -> usize {
        self.0.values.len()
    }

    /// Returns the place of a parameter.
    ///
    /// # Panics
    /// The network has no parameter of that name.
    pub(super) fn range(&self, name: &str) -> Range<usize> {
        let found = self.0.places.iter().find(|(own, _)| own == name);
        found.unwrap_or_else(|| unreachable!("a parameter of the network: {name}")).1.clone()
    }

    pub(super) fn values(&self, range: Range<usize>) -> &[f32] {
        &self.0.values[range]
    }

    /// Returns a row of gradients by their parameters' names.
    pub(super) fn named(&self, sums: &[f32], device: &Device) -> Gradients {
        let mut gradients = Gradients::default();
        for (name, range) in &self.0.places {
            let data = TensorData::new(sums[range.clone()].to_vec(), [range.len()]);
            gradients.insert(name.clone(), Tensor::from_data(data, device));
        }
        gradients
    }
}
