//! A gated recurrent unit over the history of a policy's observation.

use lifelike_checkpoint::{Checkpoint, CheckpointError};
use lifelike_dense::{Gru as Kernel, GruMemory, GruSizes};
use rayon::prelude::*;

use super::Weights;

/// Windows that a thread takes at a time.
const SHARE: usize = 16;

/// The last state of a unit that read a window, the oldest step first; as [`lifelike_dense::Gru`] has it.
#[derive(Debug, Clone, PartialEq)]
pub struct Gru(Kernel);

/// Names of its maps below the prefix.
const MAPS: [&str; 2] = ["input", "state"];

impl Gru {
    /// Reads `prefix.input` and `prefix.state`, each a linear layer to the three gates.
    ///
    /// # Errors
    /// An array is missing or of another shape.
    pub fn load(file: &Checkpoint, prefix: &str, sizes: GruSizes) -> Result<Self, CheckpointError> {
        let gates = 3 * sizes.state;
        let map = |name: &str, inputs: usize| -> Result<Vec<f32>, CheckpointError> {
            let from = Weights::under(file, prefix);
            let mut parameters = from.f32s(&format!("{name}.layers.0.weight"), &[inputs, gates])?;
            parameters.extend(from.f32s(&format!("{name}.layers.0.bias"), &[gates])?);
            Ok(parameters)
        };
        Ok(Self(Kernel::new(sizes, map(MAPS[0], sizes.inputs)?, map(MAPS[1], sizes.state)?)))
    }

    /// Writes the arrays as [`Self::load`] reads them.
    ///
    /// # Errors
    /// The names are taken.
    pub fn save_into(&self, file: &mut Checkpoint, prefix: &str) -> Result<(), CheckpointError> {
        let GruSizes { inputs, state, .. } = self.0.sizes();
        let gates = 3 * state;
        for ((name, inputs), parameters) in MAPS.iter().zip([inputs, state]).zip(self.0.parameters()) {
            let (weight, bias) = parameters.split_at(inputs * gates);
            file.put_f32(&format!("{prefix}.{name}.layers.0.weight"), &[inputs, gates], weight.to_vec())?;
            file.put_f32(&format!("{prefix}.{name}.layers.0.bias"), &[gates], bias.to_vec())?;
        }
        Ok(())
    }

    /// Numbers of a window.
    pub fn inputs(&self) -> usize {
        self.0.sizes().window()
    }

    /// Numbers of a state.
    pub fn outputs(&self) -> usize {
        self.0.sizes().state
    }

    /// Writes the last states of windows: on this thread where there are few, and then without an allocation once `memory` was used.
    ///
    /// # Shapes
    /// `windows: [N, inputs]` to `out: [N, outputs]`.
    ///
    /// # Panics
    /// A slice has another length.
    pub fn forward(&self, windows: &[f32], memory: &mut GruMemory, out: &mut [f32]) {
        if windows.len() <= SHARE * self.inputs() {
            return self.0.forward(windows, memory, out);
        }
        let shares = windows.par_chunks(SHARE * self.inputs()).zip(out.par_chunks_mut(SHARE * self.outputs()));
        shares.for_each_init(GruMemory::default, |memory, (windows, out)| self.0.forward(windows, memory, out));
    }
}
