//! Multilayer perceptrons with ELU between the layers (thesis 4.3.1: policy and value function).

use lifelike_checkpoint::rng;
use lifelike_dense::Sizes;

use crate::init;
use crate::parameters::ParameterList;

/// Sizes of a perceptron.
///
/// ```
/// use lifelike_nn::mlp::MlpConfig;
/// use lifelike_nn::parameters::ParameterList;
///
/// let mut list = ParameterList::default();
/// MlpConfig::new(12, &[64, 32], 3).add_to(&mut list, "policy", 0, "policy");
/// assert_eq!(list.finish().len(), 12 * 64 + 64 + 64 * 32 + 32 + 32 * 3 + 3);
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

    /// Adds the parameters to a network's, named `PREFIX.layers.I.weight` (`[inputs, outputs]`) and `PREFIX.layers.I.bias`: orthogonal
    /// weights from the streams `(seed, purpose, layer, 0)`, and zero biases.
    pub fn add_to(&self, list: &mut ParameterList, prefix: &str, seed: u64, purpose: &str) {
        let widths = self.widths();
        let last = widths.len() - 2;
        for (i, pair) in widths.windows(2).enumerate() {
            let gain = if i == last { self.output_gain } else { self.hidden_gain };
            let weight = init::orthogonal(&mut rng::stream(seed, purpose, i as u64, 0), pair[0], pair[1], gain);
            list.add(format!("{prefix}.layers.{i}.weight"), pair, weight);
            list.add(format!("{prefix}.layers.{i}.bias"), &pair[1..], vec![0.0; pair[1]]);
        }
    }

    /// Returns its sizes, as the kernels take them: its parameters in their own order.
    pub fn sizes(&self) -> Sizes {
        Sizes::new(&self.widths())
    }

    /// Returns the numbers in, of each hidden layer, and out.
    fn widths(&self) -> Vec<usize> {
        [self.inputs].into_iter().chain(self.hidden.iter().copied()).chain([self.outputs]).collect()
    }
}
