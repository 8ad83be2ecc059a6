//! The two networks: a Gaussian policy and a value function, both ELU perceptrons (thesis 4.3.1).

use burn::module::{Module, Param};
use burn::tensor::{Device, Tensor, TensorData};
use lifelike_nn::backprop::{BackpropError, forward};
use lifelike_nn::mlp::{Mlp, MlpConfig};
use lifelike_nn::{device, init};

use crate::error::LearnError;

/// The policy: the mean from a network, the spread a parameter of its own.
#[derive(Module, Debug)]
pub struct Actor {
    mean: Mlp,
    log_std: Param<Tensor<1>>,
}

impl Actor {
    /// # Shapes
    /// `inputs` numbers in, `outputs` (one per joint) out. The first policy's mean is near zero.
    pub fn init(inputs: usize, hidden: &[usize], outputs: usize, std: f64, seed: u64, device: &Device) -> Self {
        Self {
            mean: MlpConfig::new(inputs, hidden, outputs).with_output_gain(0.01).init(seed, "actor", device),
            log_std: init::parameter(vec![std.ln() as f32; outputs], [outputs], device),
        }
    }

    /// The network of the mean.
    pub fn network(&self) -> &Mlp {
        &self.mean
    }

    /// Mean of the outputs: rows `[B, O]` → `[B, J]`.
    ///
    /// # Errors
    /// The device does not hand out its numbers.
    pub fn means(&self, observations: Vec<f32>) -> Result<Vec<f32>, LearnError> {
        Ok(forward(&self.mean, observations, &device::inference()).map_err(unreadable)?.0)
    }

    /// Logarithm of the standard deviations, `[J]`.
    ///
    /// # Errors
    /// The device does not hand out its numbers.
    pub fn log_std(&self) -> Result<Vec<f32>, LearnError> {
        numbers(self.log_std.val())
    }

    /// With the standard deviations inside these bounds.
    #[must_use]
    pub fn bounded(mut self, [low, high]: [f64; 2]) -> Self {
        self.log_std = self.log_std.map(|tensor| tensor.clamp(low.ln(), high.ln()));
        self
    }
}

/// The value function. Its output counts in units of `1 / (1 − γ)`, what a reward of one per step is worth for ever, so
/// its targets are near one whatever the discount. It begins near zero: the random values of a fresh network would be
/// advantages too, and the first iterations would follow them anywhere.
#[derive(Module, Debug)]
pub struct Critic {
    value: Mlp,
}

impl Critic {
    /// `inputs` numbers in.
    pub fn init(inputs: usize, hidden: &[usize], seed: u64, device: &Device) -> Self {
        Self { value: MlpConfig::new(inputs, hidden, 1).with_output_gain(0.01).init(seed, "critic", device) }
    }

    /// The network.
    pub fn network(&self) -> &Mlp {
        &self.value
    }

    /// Rows `[B, P]` → `[B]`.
    ///
    /// # Errors
    /// The device does not hand out its numbers.
    pub fn values(&self, observations: Vec<f32>) -> Result<Vec<f32>, LearnError> {
        Ok(forward(&self.value, observations, &device::inference()).map_err(unreadable)?.0)
    }
}

/// Rows as a tensor.
pub(super) fn rows(values: Vec<f32>, width: usize, device: &Device) -> Tensor<2> {
    let n = values.len() / width.max(1);
    Tensor::from_data(TensorData::new(values, [n, width]), device)
}

/// A column as a tensor.
pub(super) fn column(values: Vec<f32>, device: &Device) -> Tensor<1> {
    let n = values.len();
    Tensor::from_data(TensorData::new(values, [n]), device)
}

/// A tensor's numbers.
pub(super) fn numbers<const D: usize>(tensor: Tensor<D>) -> Result<Vec<f32>, LearnError> {
    tensor.try_into_vec_as::<f32>().map_err(|e| LearnError::Mismatch {
        what: "a tensor's numbers".into(),
        expected: "f32".into(),
        got: e.to_string(),
    })
}

/// For `map_err` on passes through a network.
pub(super) fn unreadable(error: BackpropError) -> LearnError {
    LearnError::Mismatch { what: "a network's numbers".into(), expected: "f32".into(), got: error.to_string() }
}
