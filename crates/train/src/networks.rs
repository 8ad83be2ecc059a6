//! The two networks: a Gaussian policy and a value function, both ELU perceptrons (thesis 4.3.1).

use lifelike_checkpoint::{Checkpoint, CheckpointError};
use lifelike_dense::Sizes;
use lifelike_nn::mlp::MlpConfig;
use lifelike_nn::parameters::{ParameterList, Parameters};

use crate::encoder::EncoderSizes;
use crate::kernels::{ActorKernels, CriticKernels};

/// Sizes of a policy.
#[derive(Debug, Clone, PartialEq)]
pub struct ActorSize<'a> {
    /// Numbers of an observation, the encoder's included.
    pub inputs: usize,
    /// Encoder of its last numbers, whose code takes their place.
    pub encoder: Option<EncoderSizes>,
    /// Hidden layers of the network of the mean.
    pub hidden: &'a [usize],
    /// Numbers out: one per joint.
    pub outputs: usize,
}

/// The policy: the mean from a network, the standard deviation a parameter of its own.
///
/// With an encoder, the last part of an observation reaches that network as a code, and both learn together from the reward.
#[derive(Debug, Clone)]
pub struct Actor {
    encoder: Option<EncoderSizes>,
    mean: Sizes,
    parameters: Parameters,
}

/// Name of the logarithms of the standard deviations.
pub(crate) const LOG_STD: &str = "log_std";

impl Actor {
    /// The first policy's mean is near zero.
    pub fn init(size: ActorSize<'_>, std: f64, seed: u64) -> Self {
        let mut list = ParameterList::default();
        let ActorSize { encoder, .. } = size;
        let mut inputs = size.inputs;
        if let Some(encoder) = &encoder {
            encoder.add_to(&mut list, seed);
            inputs = inputs - encoder.inputs() + encoder.outputs();
        }
        let mean = MlpConfig::new(inputs, size.hidden, size.outputs).with_output_gain(0.01);
        mean.add_to(&mut list, "mean", seed, "actor");
        list.add(LOG_STD, &[size.outputs], vec![std.ln() as f32; size.outputs]);
        Self { encoder, mean: mean.sizes(), parameters: list.finish() }
    }

    /// Returns its parameters.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    pub(crate) fn parameters_mut(&mut self) -> &mut Parameters {
        &mut self.parameters
    }

    /// Mean of the outputs: rows `[B, O]` → `[B, J]`.
    pub fn means(&self, observations: &[f32]) -> Vec<f32> {
        self.kernels().means(observations)
    }

    /// Returns what it is now, made ready for many passes.
    pub fn fixed(&self) -> FixedActor {
        FixedActor(self.kernels())
    }

    /// Its networks in kernels.
    pub(crate) fn kernels(&self) -> ActorKernels {
        ActorKernels::new(self.encoder.as_ref(), &self.mean, &self.parameters)
    }

    /// Codes of normalised windows, `[B, window]` → `[B, code]`; none without an encoder.
    pub fn codes(&self, windows: &[f32]) -> Vec<f32> {
        self.kernels().codes(windows)
    }

    /// Moves every number this share of the way to those of another of its sizes.
    pub(crate) fn approach(&mut self, other: &Self, share: f32) {
        let numbers = self.parameters.values_mut().iter_mut().zip(other.parameters.values());
        numbers.for_each(|(x, y)| *x += share * (y - *x));
    }

    /// Logarithm of the standard deviations, `[J]`.
    pub fn log_std(&self) -> &[f32] {
        self.parameters.get(LOG_STD)
    }

    /// Returns a policy of the same sizes with the parameters saved as `prefix.NAME`.
    ///
    /// # Errors
    /// A parameter that is missing, unknown or of another shape.
    pub fn load_from(&self, checkpoint: &Checkpoint, prefix: &str) -> Result<Self, CheckpointError> {
        Ok(Self { parameters: self.parameters.load_from(checkpoint, prefix)?, ..self.clone() })
    }
}

/// A policy at a moment: its means, and nothing else.
#[derive(Debug, Clone)]
pub struct FixedActor(ActorKernels);

impl FixedActor {
    /// Mean of the outputs: rows `[B, O]` → `[B, J]`.
    pub fn means(&self, observations: &[f32]) -> Vec<f32> {
        self.0.means(observations)
    }
}

/// The value function. Its output counts in units of `1 / (1 − γ)`, the worth of a reward of one per step for ever.
/// Its targets are therefore near one whatever the discount. It begins near zero: the random values of a fresh network
/// would be advantages too, and the first iterations would follow them anywhere.
#[derive(Debug, Clone)]
pub struct Critic {
    value: Sizes,
    parameters: Parameters,
}

impl Critic {
    /// `inputs` numbers in.
    pub fn init(inputs: usize, hidden: &[usize], seed: u64) -> Self {
        let config = MlpConfig::new(inputs, hidden, 1).with_output_gain(0.01);
        let mut list = ParameterList::default();
        config.add_to(&mut list, "value", seed, "critic");
        Self { value: config.sizes(), parameters: list.finish() }
    }

    /// Returns its parameters.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    pub(crate) fn parameters_mut(&mut self) -> &mut Parameters {
        &mut self.parameters
    }

    /// Its network in kernels.
    pub(crate) fn kernels(&self) -> CriticKernels {
        CriticKernels::new(&self.value, &self.parameters)
    }

    /// Returns a value function of the same sizes with the parameters saved as `prefix.NAME`.
    ///
    /// # Errors
    /// A parameter that is missing, unknown or of another shape.
    pub fn load_from(&self, checkpoint: &Checkpoint, prefix: &str) -> Result<Self, CheckpointError> {
        Ok(Self { parameters: self.parameters.load_from(checkpoint, prefix)?, ..self.clone() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lifelike_dense::{Channel, GruSizes};

    fn size(encoder: Option<EncoderSizes>) -> ActorSize<'static> {
        ActorSize { inputs: 9, encoder, hidden: &[10], outputs: 2 }
    }

    fn unit_code() -> EncoderSizes {
        EncoderSizes::UnitCode(Sizes::new(&[6, 8, 4]))
    }

    fn recurrent() -> EncoderSizes {
        EncoderSizes::Recurrent(GruSizes { inputs: 2, state: 16, steps: 3 })
    }

    /// Σ gradient · means of three rows.
    fn weighed(actor: &Actor, values: &[f32], gradient: &[f32]) -> f64 {
        actor.means(values).iter().zip(gradient).map(|(mean, by)| f64::from(mean * by)).sum()
    }

    #[test]
    fn gradients_through_policy_and_each_encoder_are_those_of_finite_differences() {
        for encoder in [unit_code(), recurrent()] {
            let actor = Actor::init(size(Some(encoder.clone())), 0.4, 3);
            let values: Vec<f32> = (0..3 * 9).map(|i| ((i * 7) % 11) as f32 * 0.3 - 1.5).collect();
            let gradient = [1.0, -2.0, 30.0, 0.5, 10.0, -20.0];
            let kernels = actor.kernels();
            let mut panel = vec![Channel::ZERO; kernels.channels()];
            let means = kernels.forward(&mut panel, values.chunks_exact(9));
            assert_eq!(means, actor.means(&values));
            kernels.backward(&mut panel, &gradient);
            let mut by_number = vec![0.0; actor.parameters().len()];
            kernels.gradient(&panel, &mut by_number);

            let mut compared = 0;
            for entry in actor.parameters().layout().entries().iter().filter(|entry| entry.name != LOG_STD) {
                let range = actor.parameters().range(&entry.name);
                let scale = by_number[range.clone()].iter().fold(0.0_f32, |most, x| most.max(x.abs()));
                for at in range.step_by(3) {
                    let moved = |by: f32| {
                        let mut actor = actor.clone();
                        actor.parameters_mut().values_mut()[at] += by;
                        weighed(&actor, &values, &gradient)
                    };
                    let slope = (moved(4e-3) - moved(-4e-3)) / 8e-3;
                    let error = (slope - f64::from(by_number[at])).abs();
                    assert!(
                        error < 2e-3 * f64::from(scale),
                        "{encoder:?} {} {at}: {slope} {}",
                        entry.name,
                        by_number[at]
                    );
                    compared += 1;
                }
            }
            assert!(compared > 60, "{compared}");
        }
    }

    #[test]
    fn a_code_has_length_one_whatever_the_window() {
        let actor = Actor::init(size(Some(unit_code())), 0.4, 3);
        let codes = actor.codes(&(0..12).map(|i| i as f32 - 5.0).collect::<Vec<_>>());
        assert_eq!(codes.len(), 8);
        for code in codes.chunks_exact(4) {
            assert!((code.iter().map(|z| z * z).sum::<f32>() - 1.0).abs() < 1e-5);
        }
        let plain = Actor::init(size(None), 0.4, 3);
        assert!(plain.codes(&[0.0; 6]).is_empty());
    }
}
