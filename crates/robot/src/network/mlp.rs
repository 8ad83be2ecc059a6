//! A multilayer perceptron with ELU between its layers (thesis 4.3.1).

use lifelike_checkpoint::{Checkpoint, CheckpointError};
use lifelike_dense::{Perceptron, Sizes};

use super::{Weights, Workspace};

/// Linear layers with ELU between them; the output is linear.
#[derive(Debug, Clone, PartialEq)]
pub struct Mlp(Perceptron);

impl Mlp {
    /// Reads the layers `prefix.layers.I.weight` (`[inputs, outputs]`) and `.bias` of these widths.
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
        let mut parameters = Vec::new();
        for (i, pair) in widths.windows(2).enumerate() {
            parameters.extend(from.f32s(&format!("layers.{i}.weight"), pair)?);
            parameters.extend(from.f32s(&format!("layers.{i}.bias"), &pair[1..])?);
        }
        Ok(Self(Perceptron::new(Sizes::new(&widths), parameters)))
    }

    /// Writes the layers as [`Self::load`] reads them.
    ///
    /// # Errors
    /// The names are taken.
    pub fn save_into(&self, file: &mut Checkpoint, prefix: &str) -> Result<(), CheckpointError> {
        let parameters = self.0.parameters();
        for (i, layer) in self.0.sizes().layers().iter().enumerate() {
            let (weight, bias) = (parameters[layer.weight()].to_vec(), parameters[layer.bias()].to_vec());
            file.put_f32(&format!("{prefix}.layers.{i}.weight"), &[layer.inputs, layer.outputs], weight)?;
            file.put_f32(&format!("{prefix}.layers.{i}.bias"), &[layer.outputs], bias)?;
        }
        Ok(())
    }

    /// Numbers in.
    pub fn inputs(&self) -> usize {
        self.0.sizes().inputs()
    }

    /// Numbers out.
    pub fn outputs(&self) -> usize {
        self.0.sizes().outputs()
    }

    /// Writes the outputs of some rows: those of the network that learned, bit for bit. A [`Workspace::live`] allocates nothing
    /// once it was used for as many rows.
    ///
    /// # Shapes
    /// `rows: [N, inputs]` to `out: [N, outputs]`.
    ///
    /// # Panics
    /// `rows` or `out` has another length.
    pub fn forward(&self, rows: &[f32], work: &mut Workspace, out: &mut [f32]) {
        if work.is_live() {
            self.0.forward(rows, work.between(), out);
        } else {
            self.0.forward_many(rows, out);
        }
    }
}
