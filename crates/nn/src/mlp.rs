//! Multilayer perceptrons with ELU between the layers (thesis 4.3.1: policy and value function).

use burn::module::Module;
use burn::nn::Linear;
use burn::tensor::{Device, Tensor};
use lifelike_dense::Sizes;

use crate::elu::elu;
use crate::{device, init};
use lifelike_checkpoint::rng;

/// Sizes of an [`Mlp`].
///
/// ```
/// use burn::tensor::Tensor;
/// use lifelike_nn::{device, mlp::MlpConfig};
///
/// let mlp = MlpConfig::new(12, &[64, 32], 3).init(0, "policy", &device::inference());
/// let x = Tensor::<2>::zeros([5, 12], &device::inference());
/// assert_eq!(mlp.forward(x).dims(), [5, 3]);
/// ```
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MlpConfig {
    /// Numbers in.
    pub inputs: usize,
    /// Width of each hidden layer.
    pub hidden: Vec<usize>,
    /// Numbers out.
    pub outputs: usize,
    /// Gain of the orthogonal hidden weights.
    pub hidden_gain: f64,
    /// Gain of the orthogonal output weights.
    pub output_gain: f64,
}

impl MlpConfig {
    /// Gains √2 inside and 1 at the output.
    pub fn new(inputs: usize, hidden: &[usize], outputs: usize) -> Self {
        Self { inputs, hidden: hidden.to_vec(), outputs, hidden_gain: std::f64::consts::SQRT_2, output_gain: 1.0 }
    }

    /// Sets another gain at the output: 0.01 makes a policy begin near the zero action.
    pub fn with_output_gain(mut self, gain: f64) -> Self {
        self.output_gain = gain;
        self
    }

    /// Returns the network, with orthogonal weights from the streams `(seed, purpose, layer, 0)` and zero biases.
    pub fn init(&self, seed: u64, purpose: &str, device: &Device) -> Mlp {
        let sizes: Vec<usize> =
            [self.inputs].into_iter().chain(self.hidden.iter().copied()).chain([self.outputs]).collect();
        let last = sizes.len() - 2;
        let layers = sizes
            .windows(2)
            .enumerate()
            .map(|(i, pair)| {
                let gain = if i == last { self.output_gain } else { self.hidden_gain };
                let weight = init::orthogonal(&mut rng::stream(seed, purpose, i as u64, 0), pair[0], pair[1], gain);
                Linear {
                    weight: init::parameter(weight, [pair[0], pair[1]], device),
                    bias: Some(init::parameter(vec![0.0; pair[1]], [pair[1]], device)),
                }
            })
            .collect();
        Mlp { layers }
    }
}

/// Linear layers with ELU between them; the output is linear.
///
/// Parameters are named `layers.I.weight` (`[inputs, outputs]`) and `layers.I.bias`.
#[derive(Module, Debug)]
pub struct Mlp {
    layers: Vec<Linear>,
}

impl Mlp {
    /// # Shapes
    /// `[B, inputs]` to `[B, outputs]`.
    pub fn forward(&self, mut x: Tensor<2>) -> Tensor<2> {
        let last = self.layers.len() - 1;
        for (i, layer) in self.layers.iter().enumerate() {
            x = layer.forward(x);
            if i < last {
                x = elu(x);
            }
        }
        x
    }

    /// Returns the numbers in.
    pub fn inputs(&self) -> usize {
        self.layers.first().map_or(0, |layer| layer.weight.dims()[0])
    }

    /// Returns the numbers out.
    pub fn outputs(&self) -> usize {
        self.layers.last().map_or(0, |layer| layer.weight.dims()[1])
    }

    /// Returns its sizes, as the kernels take them: its parameters in their own order.
    pub fn sizes(&self) -> Sizes {
        let widths = self.layers.iter().map(|layer| layer.weight.dims()[1]);
        Sizes::new(&[self.inputs()].into_iter().chain(widths).collect::<Vec<_>>())
    }

    /// Returns the device that it is on, without automatic differentiation.
    pub fn device(&self) -> Device {
        self.layers.first().map_or_else(device::inference, |layer| layer.weight.val().device().inner())
    }

    /// Returns the layers, first to last (for exporters).
    pub fn layers(&self) -> &[Linear] {
        &self.layers
    }
}
