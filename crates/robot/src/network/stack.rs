//! A network of other stacks, layer by layer: what a policy that was not trained here is made of.

use lifelike_checkpoint::{Checkpoint, CheckpointError};
use lifelike_dense::{elu, layer_norm};

use super::{Weights, Workspace};

/// One layer, without its weights.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, tag = "kind", rename_all = "snake_case")]
pub enum Layer {
    /// `x W + b` (`weight: [inputs, outputs]`, `bias: [outputs]`).
    Linear {
        /// Numbers out.
        outputs: usize,
    },
    /// `w x + b`, number by number (`weight`, `bias`: `[width]`).
    Affine,
    /// `w (x - mean) / sqrt(variance + epsilon) + b` over a row (`weight`, `bias`: `[width]`).
    LayerNorm {
        /// Added to the variance.
        epsilon: f32,
    },
    /// `x`, or `exp(x) - 1` below zero.
    Elu,
    /// `max(x, 0)`.
    Relu,
    /// `x / (1 + exp(-x))`.
    Silu,
    /// Hyperbolic tangent.
    Tanh,
}

/// Layers one after another.
#[derive(Debug, Clone, PartialEq)]
pub struct Stack {
    inputs: usize,
    layers: Vec<Loaded>,
}

#[derive(Debug, Clone, PartialEq)]
struct Loaded {
    layer: Layer,
    /// Numbers out.
    width: usize,
    weight: Vec<f32>,
    bias: Vec<f32>,
}

impl Layer {
    /// Shape of the weight for a number of inputs; none for a layer without weights.
    fn weight(&self, inputs: usize) -> Option<Vec<usize>> {
        match *self {
            Self::Linear { outputs } => Some(vec![inputs, outputs]),
            Self::Affine | Self::LayerNorm { .. } => Some(vec![inputs]),
            Self::Elu | Self::Relu | Self::Silu | Self::Tanh => None,
        }
    }

    fn outputs(&self, inputs: usize) -> usize {
        if let Self::Linear { outputs } = *self { outputs } else { inputs }
    }
}

impl Stack {
    /// Reads the weights `prefix.layers.I.weight` and `.bias` of these layers.
    ///
    /// # Errors
    /// An array is missing or of another shape.
    pub fn load(file: &Checkpoint, prefix: &str, inputs: usize, layers: &[Layer]) -> Result<Self, CheckpointError> {
        let (from, mut width, mut loaded) = (Weights::under(file, prefix), inputs, Vec::new());
        for (i, layer) in layers.iter().enumerate() {
            let outputs = layer.outputs(width);
            let (weight, bias) = match layer.weight(width) {
                Some(shape) => (
                    from.f32s(&format!("layers.{i}.weight"), &shape)?,
                    from.f32s(&format!("layers.{i}.bias"), &[outputs])?,
                ),
                None => Default::default(),
            };
            loaded.push(Loaded { layer: *layer, width: outputs, weight, bias });
            width = outputs;
        }
        Ok(Self { inputs, layers: loaded })
    }

    /// Writes the weights as [`Self::load`] reads them.
    ///
    /// # Errors
    /// The names are taken.
    pub fn save_into(&self, file: &mut Checkpoint, prefix: &str) -> Result<(), CheckpointError> {
        let mut width = self.inputs;
        for (i, Loaded { layer, width: outputs, weight, bias }) in self.layers.iter().enumerate() {
            if let Some(shape) = layer.weight(width) {
                file.put_f32(&format!("{prefix}.layers.{i}.weight"), &shape, weight.clone())?;
                file.put_f32(&format!("{prefix}.layers.{i}.bias"), &[*outputs], bias.clone())?;
            }
            width = *outputs;
        }
        Ok(())
    }

    /// Numbers out.
    pub fn outputs(&self) -> usize {
        self.layers.last().map_or(self.inputs, |layer| layer.width)
    }

    /// Writes the outputs of some rows.
    ///
    /// # Shapes
    /// `rows: [N, inputs]` to `out: [N, outputs]`.
    ///
    /// # Panics
    /// `rows` or `out` has another length.
    pub fn forward(&self, rows: &[f32], work: &mut Workspace, out: &mut [f32]) {
        let n = rows.len() / self.inputs.max(1);
        assert_eq!((rows.len(), out.len()), (n * self.inputs, n * self.outputs()), "lengths of rows and outputs");
        let widest = self.layers.iter().map(|layer| layer.width).fold(self.inputs, usize::max);
        let (buffers, live) = work.parts(n * widest);
        let [now, next, ..] = buffers;
        now[..rows.len()].copy_from_slice(rows);
        let mut width = self.inputs;
        for layer in &self.layers {
            let values = &mut now[..n * width];
            if let Layer::Linear { outputs } = layer.layer {
                let into = &mut next[..n * outputs];
                Workspace::product(live, values, &layer.weight, [n, width, outputs], into);
                add(into, &layer.bias);
                std::mem::swap(now, next);
            } else {
                layer.in_place(values);
            }
            width = layer.width;
        }
        out.copy_from_slice(&now[..out.len()]);
    }
}

impl Loaded {
    /// Applies a layer that keeps the width.
    fn in_place(&self, values: &mut [f32]) {
        match self.layer {
            Layer::Linear { .. } => {}
            Layer::Affine => {
                scale(values, &self.weight);
                add(values, &self.bias);
            }
            Layer::LayerNorm { epsilon } => {
                layer_norm(values, &self.weight, epsilon);
                add(values, &self.bias);
            }
            Layer::Elu => values.iter_mut().for_each(|x| *x = elu(*x)),
            Layer::Relu => values.iter_mut().for_each(|x| *x = x.max(0.0)),
            Layer::Silu => values.iter_mut().for_each(|x| *x /= 1.0 + (-*x).exp()),
            Layer::Tanh => values.iter_mut().for_each(|x| *x = x.tanh()),
        }
    }
}

fn scale(rows: &mut [f32], by: &[f32]) {
    rows.chunks_exact_mut(by.len().max(1)).for_each(|row| row.iter_mut().zip(by).for_each(|(x, w)| *x *= w));
}

fn add(rows: &mut [f32], what: &[f32]) {
    rows.chunks_exact_mut(what.len().max(1)).for_each(|row| row.iter_mut().zip(what).for_each(|(x, b)| *x += b));
}
