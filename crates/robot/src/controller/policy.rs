//! The frozen policy: normalisation, the encoder of its own where it has one, and the network of the mean.
//!
//! Both networks are of several kinds. A further one is a file in `network`, an entry here, and a key of the header.

use lifelike_checkpoint::{Checkpoint, CheckpointError};
use lifelike_dense::{GruMemory, GruSizes};

use super::header::ControllerHeader;
use crate::network::{Gru, Mlp, Normalizer, Stack, Workspace};
use crate::{FromInput, RobotError};

/// Prefixes of its arrays in a file.
const MEAN: &str = "actor.mean";
const ENCODER: &str = "actor.encoder";
const MEMORY: &str = "actor.memory";
const NORMALIZER: &str = "normalizer";

/// Observations to outputs, deterministic: the mean of the trained Gaussian.
#[derive(Debug, Clone, PartialEq)]
pub struct FrozenPolicy {
    normalizer: Normalizer,
    encoder: Option<Encoder>,
    mean: Network,
}

/// The network that reads the last part of an observation, whose code takes that part's place.
#[derive(Debug, Clone, PartialEq)]
enum Encoder {
    /// Of a window of the reference, its code brought to length one.
    UnitCode(Mlp),
    /// Of the robot's own history.
    Recurrent(Gru),
}

impl Encoder {
    /// Reads the encoder of a header, where it has one.
    fn load(file: &Checkpoint, header: &ControllerHeader) -> Result<Option<Self>, RobotError> {
        let spec = &header.observation;
        if let Some(state) = header.memory {
            let steps = spec.reference.history;
            if steps == 0 || state == 0 || !state.is_multiple_of(GruSizes::MULTIPLE) {
                let expected = format!("a multiple of {}, and inputs.history above 0", GruSizes::MULTIPLE);
                let got = format!("{state}, and a history of {steps} steps");
                return Err(RobotError::mismatch("size of the state of a policy's memory", expected, got));
            }
            let sizes = GruSizes { inputs: spec.history_size() / steps, state, steps };
            return Ok(Some(Self::Recurrent(Gru::load(file, MEMORY, sizes)?)));
        }
        let window = spec.window_size();
        let (hidden, code) = header.encoder.clone().unwrap_or_default();
        if (window > 0) != (code > 0) {
            let what = format!("size of the code of a window of {window} numbers");
            return Err(RobotError::mismatch(what, if window > 0 { "above 0" } else { "0" }, code));
        }
        let load = || Mlp::load(file, ENCODER, window, &hidden, code);
        Ok((code > 0).then(load).transpose()?.map(Self::UnitCode))
    }

    fn save_into(&self, file: &mut Checkpoint) -> Result<(), CheckpointError> {
        match self {
            Self::UnitCode(mlp) => mlp.save_into(file, ENCODER),
            Self::Recurrent(unit) => unit.save_into(file, MEMORY),
        }
    }

    fn inputs(&self) -> usize {
        match self {
            Self::UnitCode(mlp) => mlp.inputs(),
            Self::Recurrent(unit) => unit.inputs(),
        }
    }

    fn outputs(&self) -> usize {
        match self {
            Self::UnitCode(mlp) => mlp.outputs(),
            Self::Recurrent(unit) => unit.outputs(),
        }
    }
}

/// The network of the mean.
#[derive(Debug, Clone, PartialEq)]
enum Network {
    /// As training here makes them.
    Mlp(Mlp),
    /// Of another stack.
    Stack(Stack),
}

impl Network {
    fn outputs(&self) -> usize {
        match self {
            Self::Mlp(mlp) => mlp.outputs(),
            Self::Stack(stack) => stack.outputs(),
        }
    }

    fn forward(&self, rows: &[f32], work: &mut Workspace, out: &mut [f32]) {
        match self {
            Self::Mlp(mlp) => mlp.forward(rows, work, out),
            Self::Stack(stack) => stack.forward(rows, work, out),
        }
    }
}

/// Memory for passes through a [`FrozenPolicy`].
#[derive(Debug, Clone, Default)]
pub struct PolicyWorkspace {
    network: Workspace,
    memory: GruMemory,
    windows: Vec<f32>,
    codes: Vec<f32>,
    rows: Vec<f32>,
}

impl PolicyWorkspace {
    /// For one robot: no pass allocates after the first.
    pub fn live() -> Self {
        Self { network: Workspace::live(), ..Self::default() }
    }

    /// For many observations at a time.
    pub fn batched() -> Self {
        Self::default()
    }
}

impl FrozenPolicy {
    /// Reads the networks of a header, whose sizes the arrays must confirm.
    pub(super) fn load(file: &Checkpoint, header: &ControllerHeader) -> Result<Self, RobotError> {
        let spec = &header.observation;
        let (size, joints) = (spec.size(), spec.joints.len());
        let normalizer = Normalizer::load(file, NORMALIZER, size)?;
        let encoder = Encoder::load(file, header)?;
        let inputs = encoder.as_ref().map_or(size, |e| size.saturating_sub(e.inputs()).saturating_add(e.outputs()));
        let mean = match &header.layers[..] {
            [] => Network::Mlp(Mlp::load(file, MEAN, inputs, &header.hidden, joints)?),
            layers => Network::Stack(Stack::load(file, MEAN, inputs, layers)?),
        };
        if mean.outputs() != joints {
            return Err(RobotError::mismatch("outputs of the policy", joints, mean.outputs()));
        }
        Ok(Self { normalizer, encoder, mean })
    }

    pub(super) fn save_into(&self, file: &mut Checkpoint) -> Result<(), CheckpointError> {
        self.normalizer.save_into(file, NORMALIZER)?;
        if let Some(encoder) = &self.encoder {
            encoder.save_into(file)?;
        }
        match &self.mean {
            Network::Mlp(mlp) => mlp.save_into(file, MEAN),
            Network::Stack(stack) => stack.save_into(file, MEAN),
        }
    }

    /// Numbers out, one per joint.
    pub(super) fn joints(&self) -> usize {
        self.mean.outputs()
    }

    /// The normalisation of observations.
    pub fn normalizer(&self) -> &Normalizer {
        &self.normalizer
    }

    /// Returns the codes of its own encoder for observations `[N, O]`, `[N, code]`; none where it has no encoder. Observations are normalised in place.
    ///
    /// # Panics
    /// `rows` is no multiple of the observation's length.
    pub fn codes(&self, rows: &mut [f32]) -> Vec<f32> {
        let mut work = PolicyWorkspace::batched();
        self.normalizer.normalize(rows);
        if let Some(encoder) = &self.encoder {
            self.encode(encoder, rows, &mut work);
        }
        work.codes
    }

    /// Writes the codes of windows at the ends of normalised rows.
    fn encode(&self, encoder: &Encoder, rows: &[f32], work: &mut PolicyWorkspace) {
        let (window, code, size) = (encoder.inputs(), encoder.outputs(), self.normalizer.size());
        work.windows.clear();
        work.windows.extend(rows.chunks_exact(size).flat_map(|row| &row[size - window..]));
        work.codes.resize(work.windows.len() / window * code, 0.0);
        match encoder {
            Encoder::UnitCode(mlp) => {
                mlp.forward(&work.windows, &mut work.network, &mut work.codes);
                work.codes.chunks_exact_mut(code).for_each(to_unit_length);
            }
            Encoder::Recurrent(unit) => unit.forward(&work.windows, &mut work.memory, &mut work.codes),
        }
    }

    /// Writes the outputs `[N, J]` (not clamped) for observations `[N, O]`, which are normalised in place.
    ///
    /// # Panics
    /// `rows` is no multiple of the observation's length, or `out` has the wrong length.
    pub fn outputs(&self, rows: &mut [f32], work: &mut PolicyWorkspace, out: &mut [f32]) {
        self.normalizer.normalize(rows);
        let Some(encoder) = &self.encoder else { return self.mean.forward(rows, &mut work.network, out) };
        self.encode(encoder, rows, work);
        let (size, own) = (self.normalizer.size(), self.normalizer.size() - encoder.inputs());
        work.rows.clear();
        for (row, code) in rows.chunks_exact(size).zip(work.codes.chunks_exact(encoder.outputs())) {
            work.rows.extend_from_slice(&row[..own]);
            work.rows.extend_from_slice(code);
        }
        self.mean.forward(&work.rows, &mut work.network, out);
    }
}

/// Brings a code to length one (as in CALM, Tessler et al. 2023).
fn to_unit_length(code: &mut [f32]) {
    let length = code.iter().map(|z| z * z).sum::<f32>().sqrt().max(1e-6);
    code.iter_mut().for_each(|z| *z /= length);
}
