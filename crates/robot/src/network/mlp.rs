//! A multilayer perceptron with ELU between its layers (thesis 4.3.1).

use lifelike_checkpoint::{Checkpoint, CheckpointError};

use super::{Weights, Workspace};

#[derive(Debug, Clone, PartialEq)]
struct Layer {
    inputs: usize,
    outputs: usize,
    /// `[inputs, outputs]`.
    weight: Vec<f32>,
    bias: Vec<f32>,
}

/// Linear layers with ELU between them; the output is linear.
#[derive(Debug, Clone, PartialEq)]
pub struct Mlp {
    layers: Vec<Layer>,
}

impl Mlp {
    /// Reads the layers `prefix.layers.I.weight` and `.bias` of these widths.
    ///
    /// # Errors
    /// A layer is missing or of another shape.
    pub fn load(
        file: &Checkpoint,
        prefix: &str,
        inputs: usize,
        hidden: &[usize],
        outputs: usize,
    ) -> Result<Self, CheckpointError> {
        let from = Weights::under(file, prefix);
        let widths: Vec<usize> = [inputs].into_iter().chain(hidden.iter().copied()).chain([outputs]).collect();
        let layer = |(i, pair): (usize, &[usize])| {
            Ok(Layer {
                inputs: pair[0],
                outputs: pair[1],
                weight: from.f32s(&format!("layers.{i}.weight"), pair)?,
                bias: from.f32s(&format!("layers.{i}.bias"), &pair[1..])?,
            })
        };
        Ok(Self { layers: widths.windows(2).enumerate().map(layer).collect::<Result<_, CheckpointError>>()? })
    }

    /// Writes the layers as [`Self::load`] reads them.
    ///
    /// # Errors
    /// The names are taken.
    pub fn save_into(&self, file: &mut Checkpoint, prefix: &str) -> Result<(), CheckpointError> {
        for (i, layer) in self.layers.iter().enumerate() {
            let weight = layer.weight.clone();
            file.put_f32(&format!("{prefix}.layers.{i}.weight"), &[layer.inputs, layer.outputs], weight)?;
            file.put_f32(&format!("{prefix}.layers.{i}.bias"), &[layer.outputs], layer.bias.clone())?;
        }
        Ok(())
    }

    /// Numbers in.
    pub fn inputs(&self) -> usize {
        self.layers.first().map_or(0, |layer| layer.inputs)
    }

    /// Numbers out.
    pub fn outputs(&self) -> usize {
        self.layers.last().map_or(0, |layer| layer.outputs)
    }

    /// Writes the outputs of some rows. A single row allocates nothing once `work` was used for one.
    ///
    /// # Shapes
    /// `rows: [N, inputs]` to `out: [N, outputs]`.
    ///
    /// # Panics
    /// `rows` or `out` has another length.
    pub fn forward(&self, rows: &[f32], work: &mut Workspace, out: &mut [f32]) {
        let n = rows.len() / self.inputs().max(1);
        assert_eq!((rows.len(), out.len()), (n * self.inputs(), n * self.outputs()), "rows of a perceptron");
        let widest = self.layers.iter().map(|layer| layer.outputs).max().unwrap_or(0);
        let ([from, to, ..], by_row) = work.parts(n * widest);
        let last = self.layers.len().saturating_sub(1);
        for (i, layer) in self.layers.iter().enumerate() {
            let input = if i == 0 { rows } else { &from[..n * layer.inputs] };
            let output = if i == last { &mut *out } else { &mut to[..n * layer.outputs] };
            Workspace::product(by_row, input, &layer.weight, [n, layer.inputs, layer.outputs], output);
            for row in output.chunks_exact_mut(layer.outputs.max(1)) {
                row.iter_mut().zip(&layer.bias).for_each(|(y, b)| *y += b);
                if i < last {
                    row.iter_mut().for_each(|y| *y = lifelike_dense::elu(*y));
                }
            }
            std::mem::swap(from, to);
        }
    }
}
