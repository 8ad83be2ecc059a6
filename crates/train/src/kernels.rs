//! The two networks in the kernels of the CPU: passes over panels of rows, with bits that depend on nothing but the numbers.

use std::ops::Range;

use lifelike_dense::{Channel, PackedPerceptron, ROWS, Sizes, pack, unpack};
use lifelike_nn::parameters::Parameters;
use lifelike_simd::InstructionSet;
use rayon::prelude::*;

use crate::encoder::{Encoder, EncoderSizes};

/// A perceptron, and where its numbers stand among those of its module.
#[derive(Debug, Clone)]
struct Network {
    packed: PackedPerceptron,
    range: Range<usize>,
}

impl Network {
    fn new(sizes: &Sizes, prefix: &str, parameters: &Parameters) -> Self {
        let range = parameters.layout().range_under(prefix);
        let values = &parameters.values()[range.clone()];
        let packed = PackedPerceptron::new(InstructionSet::chosen(), sizes.clone(), values);
        Self { packed, range }
    }
}

/// The policy's networks.
#[derive(Debug, Clone)]
pub(crate) struct ActorKernels {
    encoder: Option<Encoder>,
    mean: Network,
}

impl ActorKernels {
    /// Packs the networks of a policy's parameters.
    pub fn new(encoder: Option<&EncoderSizes>, mean: &Sizes, parameters: &Parameters) -> Self {
        let encoder = encoder.map(|encoder| encoder.kernels(parameters));
        Self { encoder, mean: Network::new(mean, "mean.", parameters) }
    }

    /// Packs other numbers.
    pub fn set(&mut self, values: &[f32]) {
        if let Some(encoder) = &mut self.encoder {
            encoder.set(values);
        }
        self.mean.packed.set(&values[self.mean.range.clone()]);
    }

    /// Channels of the encoder in a panel; the mean's follow.
    fn first(&self) -> usize {
        self.encoder.as_ref().map_or(0, Encoder::channels)
    }

    /// Channels of memory that a pass over a panel takes, zeros at first.
    pub fn channels(&self) -> usize {
        self.first() + self.mean.packed.channels()
    }

    /// Numbers of an observation.
    fn inputs(&self) -> usize {
        self.encoder.as_ref().map_or(0, Encoder::inputs) + self.own()
    }

    /// Numbers of an observation before the window.
    fn own(&self) -> usize {
        self.mean.packed.sizes().inputs() - self.encoder.as_ref().map_or(0, Encoder::outputs)
    }

    /// Means of at most [`ROWS`] observations.
    pub fn forward<'a>(
        &self,
        panel: &mut [Channel],
        rows: impl ExactSizeIterator<Item = &'a [f32]> + Clone,
    ) -> Vec<f32> {
        let (of_encoder, of_mean) = panel.split_at_mut(self.first());
        let mean = &self.mean.packed;
        let mut means = vec![0.0; rows.len() * mean.sizes().outputs()];
        let own = self.own();
        let (observed, codes) = mean.inputs(of_mean).split_at_mut(own);
        pack(rows.clone(), observed);
        if let Some(encoder) = &self.encoder {
            encoder.forward(of_encoder, rows.map(|row| &row[own..]), codes);
        }
        mean.forward(of_mean);
        unpack(mean.outputs(of_mean), &mut means);
        means
    }

    /// The loss's derivatives by every layer of a panel, from those by the means.
    pub fn backward(&self, panel: &mut [Channel], by_means: &[f32]) {
        let (of_encoder, of_mean) = panel.split_at_mut(self.first());
        let mean = &self.mean.packed;
        pack(by_means.chunks_exact(mean.sizes().outputs()), mean.by_outputs(of_mean));
        mean.backward(of_mean, self.encoder.is_some());
        let Some(encoder) = &self.encoder else { return };
        let own = self.own();
        encoder.backward(of_encoder, &mean.values_of_inputs(of_mean)[own..], &mean.by_inputs(of_mean)[own..]);
    }

    /// Writes the gradient by the numbers of both networks, from all panels.
    pub fn gradient(&self, panels: &[Channel], gradient: &mut [f32]) {
        let channels = self.channels();
        if let Some(encoder) = &self.encoder {
            encoder.gradient(panels, channels, gradient);
        }
        self.mean.packed.gradient(panels, channels, self.first(), &mut gradient[self.mean.range.clone()]);
    }

    /// Codes of many windows, `[N, window]` to `[N, code]`; none without an encoder.
    pub fn codes(&self, windows: &[f32]) -> Vec<f32> {
        let Some(encoder) = &self.encoder else { return Vec::new() };
        let (inputs, outputs) = (encoder.inputs(), encoder.outputs());
        let mut codes = vec![0.0; windows.len() / inputs * outputs];
        let memory = || (vec![Channel::ZERO; encoder.channels()], vec![Channel::ZERO; outputs]);
        windows.par_chunks(ROWS * inputs).zip(codes.par_chunks_mut(ROWS * outputs)).for_each_init(
            memory,
            |(panel, packed), (windows, codes)| {
                encoder.forward(panel, windows.chunks_exact(inputs), packed);
                unpack(packed, codes);
            },
        );
        codes
    }

    /// Means of many observations, `[N, O]` to `[N, J]`.
    pub fn means(&self, observations: &[f32]) -> Vec<f32> {
        let (inputs, outputs) = (self.inputs(), self.mean.packed.sizes().outputs());
        let mut means = vec![0.0; observations.len() / inputs * outputs];
        if self.encoder.is_none() {
            self.mean.packed.forward_many(observations, &mut means);
            return means;
        }
        let memory = || vec![Channel::ZERO; self.channels()];
        observations
            .par_chunks(ROWS * inputs)
            .zip(means.par_chunks_mut(ROWS * outputs))
            .for_each_init(memory, |panel, (rows, means)| {
                means.copy_from_slice(&self.forward(panel, rows.chunks_exact(inputs)))
            });
        means
    }
}

/// The value function's network.
#[derive(Debug, Clone)]
pub(crate) struct CriticKernels(Network);

impl CriticKernels {
    /// Packs the network of a value function's parameters.
    pub fn new(value: &Sizes, parameters: &Parameters) -> Self {
        Self(Network::new(value, "value.", parameters))
    }

    /// Packs other numbers.
    pub fn set(&mut self, values: &[f32]) {
        self.0.packed.set(&values[self.0.range.clone()]);
    }

    /// Channels of memory that a pass over a panel takes, zeros at first.
    pub fn channels(&self) -> usize {
        self.0.packed.channels()
    }

    /// Values of at most [`ROWS`] observations.
    pub fn forward<'a>(&self, panel: &mut [Channel], rows: impl ExactSizeIterator<Item = &'a [f32]>) -> Vec<f32> {
        let mut values = vec![0.0; rows.len()];
        pack(rows, self.0.packed.inputs(panel));
        self.0.packed.forward(panel);
        unpack(self.0.packed.outputs(panel), &mut values);
        values
    }

    /// The loss's derivatives by every layer of a panel, from those by the values.
    pub fn backward(&self, panel: &mut [Channel], by_values: &[f32]) {
        pack(by_values.chunks_exact(1), self.0.packed.by_outputs(panel));
        self.0.packed.backward(panel, false);
    }

    /// Writes the gradient by all numbers, from all panels.
    pub fn gradient(&self, panels: &[Channel], gradient: &mut [f32]) {
        self.0.packed.gradient(panels, self.channels(), 0, &mut gradient[self.0.range.clone()]);
    }

    /// Values of many observations, `[N, P]` to `[N]`.
    pub fn values(&self, observations: &[f32]) -> Vec<f32> {
        let mut values = vec![0.0; observations.len() / self.0.packed.sizes().inputs()];
        self.0.packed.forward_many(observations, &mut values);
        values
    }
}
