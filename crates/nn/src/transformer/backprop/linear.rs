//! Products with weights, and their gradients, in the kernels of [`crate::rows`].

use std::ops::Range;

use super::places::Places;
use crate::rows::{PackedWeight, bias_gradient, weight_gradient};

/// A linear map, its weight packed: once for all parts of a batch.
#[derive(Debug, Clone)]
pub(super) struct Linear {
    shape: [usize; 2],
    weight: PackedWeight,
    /// Empty where the map has none.
    bias: Vec<f32>,
    /// Where the gradients of weight and bias belong.
    places: [Range<usize>; 2],
}

impl Linear {
    /// x · weight + bias, of an [`Affine`](crate::transformer::heads::Affine) by its name.
    pub(super) fn affine(places: &Places, name: &str, inputs: usize) -> Self {
        let mut map = Self::new(places, &format!("{name}.weight"), inputs);
        map.places[1] = places.range(&format!("{name}.bias"));
        map.bias = places.values(map.places[1].clone()).to_vec();
        map
    }

    /// x · weight, of a weight by its name.
    pub(super) fn new(places: &Places, name: &str, inputs: usize) -> Self {
        let place = places.range(name);
        let shape = [inputs, place.len() / inputs.max(1)];
        let weight = PackedWeight::new(places.values(place.clone()), shape);
        Self { shape, weight, bias: Vec::new(), places: [place, 0..0] }
    }

    /// Returns the numbers of a row that comes out.
    pub(super) fn outputs(&self) -> usize {
        self.shape[1]
    }

    /// `[rows, inputs]` to `[rows, outputs]`.
    pub(super) fn forward(&self, x: &[f32]) -> Vec<f32> {
        self.weight.forward(x, &self.bias)
    }

    /// Returns the gradient by x from the one by the output.
    pub(super) fn by_input(&self, gradient: &[f32]) -> Vec<f32> {
        self.weight.by_input(gradient)
    }

    /// Adds the gradients of weight and bias for the `x` that [`Self::forward`] met.
    pub(super) fn learn(&self, x: &[f32], gradient: &[f32], sums: &mut [f32]) {
        let [weight, bias] = &self.places;
        weight_gradient(x, gradient, self.shape, &mut sums[weight.clone()]);
        if !bias.is_empty() {
            bias_gradient(gradient, &mut sums[bias.clone()]);
        }
    }

    /// [`Self::learn`] and [`Self::by_input`].
    pub(super) fn backward(&self, x: &[f32], gradient: &[f32], sums: &mut [f32]) -> Vec<f32> {
        self.learn(x, gradient, sums);
        self.by_input(gradient)
    }
}
