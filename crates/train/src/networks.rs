//! The two networks: a Gaussian policy and a value function, both ELU perceptrons (thesis 4.3.1).

use burn::module::{Module, Param};
use burn::tensor::{Device, Tensor, TensorData};
use lifelike_nn::adam::{Adam, AdamConfig};
use lifelike_nn::backprop::{Pass, backward, backward_through, forward};
use lifelike_nn::flat::Flat;
use lifelike_nn::gradients::Gradients;
use lifelike_nn::mlp::{Mlp, MlpConfig};
use lifelike_nn::numbers::read;
use lifelike_nn::{device, init};

use crate::TrainError;
use crate::kernels::{ActorKernels, CriticKernels};

/// Sizes of a policy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActorSize<'a> {
    /// Numbers of an observation, the window included.
    pub inputs: usize,
    /// Its last numbers, which the encoder reads; 0 without.
    pub window: usize,
    /// Hidden layers of the encoder.
    pub encoder: &'a [usize],
    /// Size of the code that takes the window's place.
    pub code: usize,
    /// Hidden layers of the network of the mean.
    pub hidden: &'a [usize],
    /// Numbers out: one per joint.
    pub outputs: usize,
}

/// The policy: the mean from a network, the standard deviation a parameter of its own.
///
/// With an encoder, the window of the reference reaches that network as a code of length one (as in CALM, Tessler et al.
/// 2023), and encoder and policy learn together from the reward: the end-to-end codes of Table 4.2.
#[derive(Module, Debug)]
pub struct Actor {
    encoder: Option<Mlp>,
    mean: Mlp,
    log_std: Param<Tensor<1>>,
}

/// Values of a forward pass that the backward pass needs.
#[derive(Debug, Clone)]
pub struct ActorPass {
    mean: Pass,
    encoder: Option<Encoding>,
}

#[derive(Debug, Clone)]
struct Encoding {
    pass: Pass,
    /// Codes of length one, and the lengths they had, `[B, code]` and `[B]`.
    codes: Vec<f32>,
    lengths: Vec<f32>,
}

impl Actor {
    /// The first policy's mean is near zero.
    pub fn init(size: ActorSize<'_>, std: f64, seed: u64, device: &Device) -> Self {
        let encoder = (size.window > 0)
            .then(|| MlpConfig::new(size.window, size.encoder, size.code).init(seed, "encoder", device));
        let inputs = size.inputs - size.window + size.code;
        let mean = MlpConfig::new(inputs, size.hidden, size.outputs).with_output_gain(0.01);
        Self {
            encoder,
            mean: mean.init(seed, "actor", device),
            log_std: init::parameter(vec![std.ln() as f32; size.outputs], [size.outputs], device),
        }
    }

    /// Mean of the outputs: rows `[B, O]` → `[B, J]`.
    ///
    /// # Errors
    /// Tensor data could not be read from the device.
    pub fn means(&self, observations: Vec<f32>) -> Result<Vec<f32>, TrainError> {
        self.fixed()?.means(&observations)
    }

    /// Returns what it is now, made ready for many passes.
    ///
    /// # Errors
    /// Tensor data could not be read from the device.
    pub fn fixed(&self) -> Result<FixedActor, TrainError> {
        if self.device() == device::inference() {
            return Ok(FixedActor(Fixed::Kernels(self.kernels(&numbers(self)?))));
        }
        Ok(FixedActor(Fixed::Tensors(self.clone())))
    }

    /// Its networks in kernels; `flat` holds its numbers.
    pub(crate) fn kernels(&self, flat: &Flat) -> ActorKernels {
        ActorKernels::new(self.encoder.as_ref(), &self.mean, flat)
    }

    /// Mean of the outputs in tensors, on whatever device, with what [`Self::backward`] needs.
    ///
    /// # Errors
    /// Tensor data could not be read from the device.
    pub fn forward(&self, observations: Vec<f32>) -> Result<(Vec<f32>, ActorPass), TrainError> {
        let Some(encoder) = &self.encoder else {
            let (means, mean) = forward(&self.mean, observations)?;
            return Ok((means, ActorPass { mean, encoder: None }));
        };
        let (window, code) = (encoder.inputs(), encoder.outputs());
        let own = self.mean.inputs() - code;
        let batch = observations.len() / (own + window);
        let windows: Vec<f32> = observations.chunks_exact(own + window).flat_map(|row| &row[own..]).copied().collect();
        let (mut codes, pass) = forward(encoder, windows)?;
        let lengths: Vec<f32> = codes.chunks_exact_mut(code).map(normalise).collect();
        let mut rows = Vec::with_capacity(batch * (own + code));
        for (row, code) in observations.chunks_exact(own + window).zip(codes.chunks_exact(code)) {
            rows.extend_from_slice(&row[..own]);
            rows.extend_from_slice(code);
        }
        let (means, mean) = forward(&self.mean, rows)?;
        Ok((means, ActorPass { mean, encoder: Some(Encoding { pass, codes, lengths }) }))
    }

    /// Gradients of both networks by name; `by_mean` is the loss's derivative by each mean, `[B, J]`.
    ///
    /// # Errors
    /// Tensor data could not be read from the device.
    pub fn backward(&self, pass: ActorPass, by_mean: Vec<f32>) -> Result<Gradients, TrainError> {
        let (Some(encoder), Some(encoding)) = (&self.encoder, pass.encoder) else {
            return Ok(backward(&self.mean, pass.mean, by_mean, "mean")?);
        };
        let (mut gradients, by_row) = backward_through(&self.mean, pass.mean, by_mean, "mean")?;
        let (inputs, code) = (self.mean.inputs(), encoder.outputs());
        let mut by_code = Vec::with_capacity(encoding.codes.len());
        let codes = encoding.codes.chunks_exact(code).zip(encoding.lengths);
        for (row, (z, length)) in by_row.chunks_exact(inputs).zip(codes) {
            // z = e / |e|: what points along z changes nothing.
            let gradient = &row[inputs - code..];
            let along: f32 = z.iter().zip(gradient).map(|(z, s)| z * s).sum();
            by_code.extend(z.iter().zip(gradient).map(|(z, s)| (s - along * z) / length));
        }
        gradients.extend(backward(encoder, encoding.pass, by_code, "encoder")?);
        Ok(gradients)
    }

    /// Codes of length one of normalised windows, `[B, window]` → `[B, code]`; none without an encoder.
    ///
    /// # Errors
    /// Tensor data could not be read from the device.
    pub fn codes(&self, windows: Vec<f32>) -> Result<Vec<f32>, TrainError> {
        let Some(encoder) = &self.encoder else { return Ok(Vec::new()) };
        let (mut codes, _) = forward(encoder, windows)?;
        codes.chunks_exact_mut(encoder.outputs()).for_each(|code| {
            normalise(code);
        });
        Ok(codes)
    }

    /// Returns it with every number this share of the way to those of another of its sizes.
    ///
    /// # Errors
    /// Tensor data could not be read from the device.
    pub(crate) fn towards(self, other: &Self, share: f32) -> Result<Self, TrainError> {
        let (mut own, other) = (numbers(&self)?, numbers(other)?);
        own.values_mut().iter_mut().zip(other.values()).for_each(|(x, y)| *x += share * (y - *x));
        Ok(own.into_module(self, &mut Adam::new(AdamConfig::adam())))
    }

    /// Returns the device that it is on.
    pub fn device(&self) -> Device {
        self.mean.device()
    }

    /// Logarithm of the standard deviations, `[J]`.
    ///
    /// # Errors
    /// Tensor data could not be read from the device.
    pub fn log_std(&self) -> Result<Vec<f32>, TrainError> {
        Ok(read(self.log_std.val())?)
    }

    /// With the standard deviations inside these bounds.
    #[must_use]
    pub fn bounded(mut self, [low, high]: [f64; 2]) -> Self {
        self.log_std = self.log_std.map(|tensor| tensor.clamp(low.ln(), high.ln()));
        self
    }
}

/// A policy at a moment: its means, and nothing else.
#[derive(Debug, Clone)]
pub struct FixedActor(Fixed<ActorKernels, Actor>);

/// A value function at a moment.
#[derive(Debug, Clone)]
pub struct FixedCritic(Fixed<CriticKernels, Critic>);

/// A network on the CPU, or on a card.
#[derive(Debug, Clone)]
enum Fixed<K, T> {
    Kernels(K),
    Tensors(T),
}

/// Rows that cross to a card at once.
const CROSSING: usize = 4096;

/// `forward` of some rows after others.
fn crossing(
    rows: &[f32],
    width: usize,
    forward: impl Fn(Vec<f32>) -> Result<Vec<f32>, TrainError>,
) -> Result<Vec<f32>, TrainError> {
    let parts = rows.chunks(CROSSING * width).map(|part| forward(part.to_vec()));
    Ok(parts.collect::<Result<Vec<_>, _>>()?.concat())
}

impl FixedActor {
    /// Mean of the outputs: rows `[B, O]` → `[B, J]`.
    ///
    /// # Errors
    /// Tensor data could not be read from the device.
    pub fn means(&self, observations: &[f32]) -> Result<Vec<f32>, TrainError> {
        match &self.0 {
            Fixed::Kernels(kernels) => Ok(kernels.means(observations)),
            Fixed::Tensors(actor) => {
                let code = actor.encoder.as_ref().map_or(0, |e| e.outputs());
                let width = actor.mean.inputs() - code + actor.encoder.as_ref().map_or(0, |e| e.inputs());
                crossing(observations, width, |rows| Ok(actor.forward(rows)?.0))
            }
        }
    }
}

impl FixedCritic {
    /// Rows `[B, P]` → `[B]`.
    ///
    /// # Errors
    /// Tensor data could not be read from the device.
    pub fn values(&self, observations: &[f32]) -> Result<Vec<f32>, TrainError> {
        match &self.0 {
            Fixed::Kernels(kernels) => Ok(kernels.values(observations)),
            Fixed::Tensors(critic) => {
                crossing(observations, critic.value.inputs(), |rows| Ok(forward(&critic.value, rows)?.0))
            }
        }
    }
}

/// The numbers of a network that is not to learn.
fn numbers<M: Module>(module: &M) -> Result<Flat, TrainError> {
    Ok(Flat::of(module, &Adam::new(AdamConfig::adam()))?)
}

/// Brings a code to length one; the length that it had (never zero).
fn normalise(code: &mut [f32]) -> f32 {
    let length = code.iter().map(|z| z * z).sum::<f32>().sqrt().max(1e-6);
    code.iter_mut().for_each(|z| *z /= length);
    length
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

    /// Returns what it is now, made ready for many passes.
    ///
    /// # Errors
    /// Tensor data could not be read from the device.
    pub fn fixed(&self) -> Result<FixedCritic, TrainError> {
        if self.value.device() == device::inference() {
            return Ok(FixedCritic(Fixed::Kernels(self.kernels(&numbers(self)?))));
        }
        Ok(FixedCritic(Fixed::Tensors(self.clone())))
    }

    /// Its network in kernels; `flat` holds its numbers.
    pub(crate) fn kernels(&self, flat: &Flat) -> CriticKernels {
        CriticKernels::new(&self.value, flat)
    }
}

/// Rows as a tensor.
pub fn rows(values: Vec<f32>, width: usize, device: &Device) -> Tensor<2> {
    let n = values.len() / width.max(1);
    Tensor::from_data(TensorData::new(values, [n, width]), device)
}

/// A column as a tensor.
pub fn column(values: Vec<f32>, device: &Device) -> Tensor<1> {
    let n = values.len();
    Tensor::from_data(TensorData::new(values, [n]), device)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use lifelike_dense::Channel;

    const SIZE: ActorSize<'_> = ActorSize { inputs: 9, window: 6, encoder: &[8], code: 4, hidden: &[10], outputs: 2 };

    #[test]
    fn gradients_through_policy_and_encoder_are_those_of_automatic_differentiation() {
        let actor = Actor::init(SIZE, 0.4, 3, &device::training());
        let values: Vec<f32> = (0..3 * 9).map(|i| ((i * 7) % 11) as f32 * 0.3 - 1.5).collect();
        let gradient = vec![1.0, -2.0, 30.0, 0.5, 10.0, -20.0];

        let whole = rows(values.clone(), 9, &device::training());
        let encoded = actor.encoder.as_ref().unwrap().forward(whole.clone().slice([0..3, 3..9]));
        let length = encoded.clone().square().sum_dim(1).sqrt();
        let input = Tensor::cat(vec![whole.slice([0..3, 0..3]), encoded / length], 1);
        let means = actor.mean.forward(input);
        let loss = (means.clone() * rows(gradient.clone(), 2, &device::training())).sum();
        let expected = Gradients::of(&actor, loss.backward());

        let flat = numbers(&actor).unwrap();
        let kernels = actor.kernels(&flat);
        let mut panel = vec![Channel::ZERO; kernels.channels()];
        let fixed = kernels.forward(&mut panel, values.chunks_exact(9));
        kernels.backward(&mut panel, &gradient);
        let mut by_number = vec![0.0; flat.values().len()];
        kernels.gradient(&panel, &mut by_number);
        assert_eq!(fixed, actor.means(values.clone()).unwrap());

        let (got_means, pass) = actor.forward(values).unwrap();
        for ((a, b), fixed) in got_means.iter().zip(read(means.without_autodiff()).unwrap()).zip(fixed) {
            assert!((a - b).abs() < 1e-5 && (fixed - b).abs() < 1e-5, "{a} {b} {fixed}");
        }
        let got = actor.backward(pass, gradient).unwrap();
        assert_eq!(got.names().collect::<Vec<_>>(), expected.names().collect::<Vec<_>>());
        for name in expected.names() {
            let (a, b) = (got.get(name).unwrap().clone(), expected.get(name).unwrap().clone().without_autodiff());
            let (a, b) = (read(a).unwrap(), read(b).unwrap());
            let scale = b.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
            for ((a, b), kernels) in a.into_iter().zip(b).zip(&by_number[flat.range(name)]) {
                assert!((a - b).abs() <= 2e-5 * b.abs().max(1.0), "{name}: {a} {b}");
                assert!((kernels - b).abs() <= 1e-6 * scale, "{name}: {kernels} in the kernels, {b}");
            }
        }
    }

    #[test]
    fn a_code_has_length_one_whatever_the_window() {
        let actor = Actor::init(SIZE, 0.4, 3, &device::inference());
        let codes = actor.codes((0..12).map(|i| i as f32 - 5.0).collect()).unwrap();
        assert_eq!(codes.len(), 8);
        for code in codes.chunks_exact(4) {
            assert!((code.iter().map(|z| z * z).sum::<f32>() - 1.0).abs() < 1e-5);
        }
        let plain = Actor::init(ActorSize { window: 0, code: 0, ..SIZE }, 0.4, 3, &device::inference());
        assert!(plain.codes(vec![0.0; 6]).unwrap().is_empty());
    }
}
