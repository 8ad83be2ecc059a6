//! Encoders of the last part of an observation: networks that learn with the policy, whose codes take that part's place.
//!
//! A further kind is a file with its kernels, an entry here in both enums, and the frozen network in `lifelike-robot`.

use std::ops::Range;

use lifelike_dense::{Channel, GruSizes, PackedGru, PackedPerceptron, ROWS, Sizes, pack};
use lifelike_nn::mlp::MlpConfig;
use lifelike_nn::parameters::{ParameterList, Parameters};
use lifelike_simd::InstructionSet;

/// Kind and sizes of an encoder.
#[derive(Debug, Clone, PartialEq)]
pub enum EncoderSizes {
    /// A perceptron whose outputs are brought to length one (as in CALM, Tessler et al. 2023): the end-to-end codes of
    /// Table 4.2.
    UnitCode(Sizes),
    /// A gated recurrent unit over the steps of the part; the code is its last state.
    Recurrent(GruSizes),
}

impl EncoderSizes {
    /// Prefix of its parameters.
    const PREFIX: &'static str = "encoder";
    /// Prefixes of a recurrent unit's maps.
    const MAPS: [&'static str; 2] = ["memory.input", "memory.state"];

    /// Returns the numbers that it reads.
    pub fn inputs(&self) -> usize {
        match self {
            Self::UnitCode(sizes) => sizes.inputs(),
            Self::Recurrent(sizes) => sizes.window(),
        }
    }

    /// Returns the numbers of a code.
    pub fn outputs(&self) -> usize {
        match self {
            Self::UnitCode(sizes) => sizes.outputs(),
            Self::Recurrent(sizes) => sizes.state,
        }
    }

    /// Returns the multiplications of a pass over one row.
    pub fn multiplications(&self) -> usize {
        match self {
            Self::UnitCode(sizes) => sizes.layers().iter().map(|layer| layer.inputs * layer.outputs).sum(),
            Self::Recurrent(sizes) => sizes.steps * 3 * sizes.state * (sizes.inputs + sizes.state),
        }
    }

    /// Adds its first parameters to a policy's.
    pub(crate) fn add_to(&self, list: &mut ParameterList, seed: u64) {
        match self {
            Self::UnitCode(sizes) => {
                let hidden: Vec<usize> = sizes.layers().iter().skip(1).map(|layer| layer.inputs).collect();
                let config = MlpConfig::new(sizes.inputs(), &hidden, sizes.outputs());
                config.add_to(list, Self::PREFIX, seed, "encoder");
            }
            Self::Recurrent(sizes) => {
                for (inputs, prefix) in [sizes.inputs, sizes.state].into_iter().zip(Self::MAPS) {
                    MlpConfig::new(inputs, &[], 3 * sizes.state).add_to(list, prefix, seed, prefix);
                }
            }
        }
    }

    /// Returns its kernels with the parameters of a policy.
    pub(crate) fn kernels(&self, parameters: &Parameters) -> Encoder {
        let set = InstructionSet::chosen();
        match self {
            Self::UnitCode(sizes) => {
                let range = parameters.layout().range_under(&format!("{}.", Self::PREFIX));
                let values = &parameters.values()[range.clone()];
                Encoder { kernels: Kernels::UnitCode(PackedPerceptron::new(set, sizes.clone(), values)), range }
            }
            Self::Recurrent(sizes) => {
                let [input, state] = Self::MAPS.map(|map| parameters.layout().range_under(&format!("{map}.")));
                let range = input.start..state.end;
                let values = &parameters.values()[range.clone()];
                Encoder { kernels: Kernels::Recurrent(PackedGru::new(set, *sizes, values)), range }
            }
        }
    }
}

/// An encoder in kernels, and where its numbers stand among the policy's.
#[derive(Debug, Clone)]
pub(crate) struct Encoder {
    kernels: Kernels,
    range: Range<usize>,
}

#[derive(Debug, Clone)]
enum Kernels {
    UnitCode(PackedPerceptron),
    Recurrent(PackedGru),
}

impl Encoder {
    /// Packs other numbers of the policy's.
    pub fn set(&mut self, values: &[f32]) {
        match &mut self.kernels {
            Kernels::UnitCode(perceptron) => perceptron.set(&values[self.range.clone()]),
            Kernels::Recurrent(unit) => unit.set(&values[self.range.clone()]),
        }
    }

    /// Channels of memory that a pass over a panel takes, zeros at first.
    pub fn channels(&self) -> usize {
        match &self.kernels {
            Kernels::UnitCode(perceptron) => perceptron.channels(),
            Kernels::Recurrent(unit) => unit.channels(),
        }
    }

    /// Numbers that it reads.
    pub fn inputs(&self) -> usize {
        match &self.kernels {
            Kernels::UnitCode(perceptron) => perceptron.sizes().inputs(),
            Kernels::Recurrent(unit) => unit.sizes().window(),
        }
    }

    /// Numbers of a code.
    pub fn outputs(&self) -> usize {
        match &self.kernels {
            Kernels::UnitCode(perceptron) => perceptron.sizes().outputs(),
            Kernels::Recurrent(unit) => unit.sizes().state,
        }
    }

    /// Writes the codes of at most [`ROWS`] windows.
    pub fn forward<'a>(
        &self,
        panel: &mut [Channel],
        windows: impl Iterator<Item = &'a [f32]> + Clone,
        codes: &mut [Channel],
    ) {
        match &self.kernels {
            Kernels::UnitCode(perceptron) => {
                pack(windows, perceptron.inputs(panel));
                perceptron.forward(panel);
                let raw = perceptron.outputs(panel);
                let lengths = lengths(raw);
                for (code, raw) in codes.iter_mut().zip(raw) {
                    (0..ROWS).for_each(|r| code[r] = raw[r] / lengths[r]);
                }
            }
            Kernels::Recurrent(unit) => {
                unit.forward(panel, windows);
                codes.copy_from_slice(unit.outputs(panel));
            }
        }
    }

    /// The loss's derivatives by every layer of a panel, from those by its codes.
    pub fn backward(&self, panel: &mut [Channel], codes: &[Channel], by_codes: &[Channel]) {
        match &self.kernels {
            Kernels::UnitCode(perceptron) => {
                let lengths = lengths(perceptron.outputs(panel));
                // z = e / |e|: what points along z changes nothing.
                let mut along = [0.0_f32; ROWS];
                for (z, by) in codes.iter().zip(by_codes) {
                    (0..ROWS).for_each(|r| along[r] += z[r] * by[r]);
                }
                for ((to, z), by) in perceptron.by_outputs(panel).iter_mut().zip(codes).zip(by_codes) {
                    (0..ROWS).for_each(|r| to[r] = (by[r] - along[r] * z[r]) / lengths[r]);
                }
                perceptron.backward(panel, false);
            }
            Kernels::Recurrent(unit) => {
                unit.by_outputs(panel).copy_from_slice(by_codes);
                unit.backward(panel);
            }
        }
    }

    /// Writes its part of the gradient by the policy's numbers, from all panels; its channels come first in each.
    pub fn gradient(&self, panels: &[Channel], channels: usize, gradient: &mut [f32]) {
        let own = &mut gradient[self.range.clone()];
        match &self.kernels {
            Kernels::UnitCode(perceptron) => perceptron.gradient(panels, channels, 0, own),
            Kernels::Recurrent(unit) => unit.gradient(panels, channels, 0, own),
        }
    }
}

/// Lengths of the codes of a panel (never zero).
fn lengths(codes: &[Channel]) -> [f32; ROWS] {
    let mut squares = [0.0_f32; ROWS];
    for code in codes {
        squares.iter_mut().zip(code.iter()).for_each(|(sum, z)| *sum += z * z);
    }
    squares.map(|square| square.sqrt().max(1e-6))
}
