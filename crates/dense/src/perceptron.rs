//! Perceptrons: linear layers with ELU between them, the output linear.

use lifelike_simd::InstructionSet;
use rayon::prelude::*;

use crate::product::RowsOfLayer;

/// Rows that a thread takes at a time.
const SHARE: usize = 32;

/// Sizes of a perceptron's layers, and where each layer's numbers stand among all of its parameters: weight `[inputs, outputs]`
/// and bias of the first layer, of the second, and so on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sizes(Vec<LayerSizes>);

/// Sizes of one layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LayerSizes {
    /// Numbers in.
    pub inputs: usize,
    /// Numbers out.
    pub outputs: usize,
    /// Its weight's first number.
    first: usize,
}

impl LayerSizes {
    /// Returns where its weight stands.
    pub fn weight(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.inputs * self.outputs
    }

    /// Returns where its bias stands.
    pub fn bias(&self) -> std::ops::Range<usize> {
        let first = self.weight().end;
        first..first + self.outputs
    }
}

impl Sizes {
    /// Returns the sizes of layers of these widths: inputs, hidden layers, outputs.
    ///
    /// # Panics
    /// There are fewer than two, or one is zero.
    pub fn new(widths: &[usize]) -> Self {
        assert!(widths.len() >= 2 && !widths.contains(&0), "a perceptron of widths {widths:?}");
        let mut first = 0;
        let layers = widths.windows(2).map(|pair| {
            let layer = LayerSizes { inputs: pair[0], outputs: pair[1], first };
            first = layer.bias().end;
            layer
        });
        Self(layers.collect())
    }

    /// Returns the layers, first to last.
    pub fn layers(&self) -> &[LayerSizes] {
        &self.0
    }

    /// Returns the numbers in.
    pub fn inputs(&self) -> usize {
        self.0[0].inputs
    }

    /// Returns the numbers out.
    pub fn outputs(&self) -> usize {
        self.0[self.0.len() - 1].outputs
    }

    /// Returns the number of parameters.
    pub fn parameters(&self) -> usize {
        self.0[self.0.len() - 1].bias().end
    }
}

/// A perceptron for rows as they come: for one robot, or some. Many rows with a network that learns are
/// [`crate::PackedPerceptron`]'s; both give the same bits.
#[derive(Debug, Clone, PartialEq)]
pub struct Perceptron {
    sizes: Sizes,
    parameters: Vec<f32>,
}

/// Memory between the layers.
pub type Between = [Vec<f32>; 2];

impl Perceptron {
    /// Takes parameters, in the order of [`Sizes`].
    ///
    /// # Panics
    /// There are more or fewer than the sizes say.
    pub fn new(sizes: Sizes, parameters: Vec<f32>) -> Self {
        assert_eq!(parameters.len(), sizes.parameters(), "parameters of a perceptron");
        Self { sizes, parameters }
    }

    /// Returns the sizes.
    pub fn sizes(&self) -> &Sizes {
        &self.sizes
    }

    /// Returns the parameters.
    pub fn parameters(&self) -> &[f32] {
        &self.parameters
    }

    /// Writes the outputs of rows, on this thread. Nothing is allocated once `between` was used for as many rows.
    ///
    /// # Shapes
    /// `rows: [N, inputs]` to `out: [N, outputs]`.
    ///
    /// # Panics
    /// A slice has another length.
    pub fn forward(&self, rows: &[f32], between: &mut Between, out: &mut [f32]) {
        let n = rows.len() / self.sizes.inputs();
        assert_eq!(
            (rows.len(), out.len()),
            (n * self.sizes.inputs(), n * self.sizes.outputs()),
            "rows of a perceptron"
        );
        let set = InstructionSet::chosen();
        let ([.., last], [from, to]) = (self.sizes.layers(), between) else { return };
        let widest = n * self.sizes.layers().iter().map(|layer| layer.inputs).max().unwrap_or(0);
        for buffer in [&mut *from, &mut *to] {
            buffer.resize(widest.max(buffer.len()), 0.0);
        }
        for layer in self.sizes.layers() {
            let rows = if layer.first == 0 { rows } else { &from[..n * layer.inputs] };
            let hidden = layer != last;
            let out = if hidden { &mut to[..n * layer.outputs] } else { &mut *out };
            let (weight, bias) = (&self.parameters[layer.weight()], &self.parameters[layer.bias()]);
            set.run(RowsOfLayer { rows, weight, bias, hidden, outputs: layer.outputs, out });
            std::mem::swap(from, to);
        }
    }

    /// Does the same on all threads.
    ///
    /// # Panics
    /// As [`Self::forward`].
    pub fn forward_many(&self, rows: &[f32], out: &mut [f32]) {
        let (i, o) = (self.sizes.inputs(), self.sizes.outputs());
        assert_eq!((rows.len() % i, out.len()), (0, rows.len() / i * o), "rows of a perceptron");
        rows.par_chunks(SHARE * i).zip(out.par_chunks_mut(SHARE * o)).for_each_init(
            Between::default,
            |between, (rows, out)| {
                self.forward(rows, between, out);
            },
        );
    }
}
