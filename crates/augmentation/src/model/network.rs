//! All steps of some sequences at once, forward and backward.

use lifelike_nn::fusion::{
    AttentionPass, GateAddNorm, GatePass, GatedResidual, GatedResidualPass, HistoryAttention, Lstm, LstmPass,
    LstmState, SelectionPass, VariableSelection,
};
use lifelike_nn::rows::{Layout, Linear, add};

use super::sizes::{Backbone, SatSizes};

/// The network with its weights packed.
///
/// The thesis' encoder reads the last 128 steps anew for every step; this one reads a sequence once: its LSTM
/// remembers from the sequence's begin, attention looks at the last K steps as there. So a step costs one step.
#[derive(Debug, Clone)]
pub struct Network {
    pub(super) sizes: SatSizes,
    pub(super) encoder: VariableSelection,
    pub(super) decoder: VariableSelection,
    pub(super) backbone: Layers,
    pub(super) attention: Option<Attention>,
    pub(super) output: Linear,
}

/// Layer before attention.
#[derive(Debug, Clone)]
pub(super) enum Layers {
    None,
    Dense(Box<[Linear; 2]>),
    Lstm(Box<Recurrent>),
}

/// The LSTM over the past, the step of another for the present, and the gate beside both.
#[derive(Debug, Clone)]
pub(super) struct Recurrent {
    pub(super) encoder: Lstm,
    pub(super) decoder: Lstm,
    pub(super) gate: GateAddNorm,
}

/// Attention and what follows it.
#[derive(Debug, Clone)]
pub(super) struct Attention {
    pub(super) history: HistoryAttention,
    pub(super) gate: GateAddNorm,
    pub(super) residual: GatedResidual,
    pub(super) output_gate: GateAddNorm,
}

/// Numbers that the way back needs.
#[derive(Debug, Clone)]
pub struct NetworkPass {
    encoder: SelectionPass,
    decoder: SelectionPass,
    backbone: LayersPass,
    attention: Option<(AttentionPass, GatePass, GatedResidualPass, GatePass)>,
    last: Vec<f32>,
    sequences: usize,
}

#[derive(Debug, Clone)]
enum LayersPass {
    None,
    /// Inputs of both layers, rows of the encoder then of the decoder.
    Dense([Vec<f32>; 3]),
    Lstm {
        encoder: LstmPass,
        decoder: LstmPass,
        gate: GatePass,
    },
}

impl Network {
    /// Packs parameters that stand as [`SatSizes::layout`] says.
    pub fn new(sizes: SatSizes, layout: &Layout, values: &[f32]) -> Self {
        let c = sizes.width;
        let gate = |name: &str| GateAddNorm::new(name, c, c, layout, values);
        let lstm = |name: &str| Lstm::new(name, c, c, layout, values);
        let linear = |name: &str, shape| Linear::new(name, shape, layout, values);
        Self {
            encoder: VariableSelection::new("encoder.selection", sizes.encoder(), layout, values),
            decoder: VariableSelection::new("decoder.selection", sizes.decoder(), layout, values),
            backbone: match sizes.backbone {
                Backbone::None => Layers::None,
                Backbone::Dense => Layers::Dense(Box::new(["dense.0", "dense.1"].map(|name| linear(name, [c, c])))),
                Backbone::Lstm => Layers::Lstm(Box::new(Recurrent {
                    encoder: lstm("encoder.lstm"),
                    decoder: lstm("decoder.lstm"),
                    gate: gate("lstm_gate"),
                })),
            },
            attention: sizes.attention.then(|| Attention {
                history: HistoryAttention::new("attention", sizes.attention(), layout, values),
                gate: gate("attention_gate"),
                residual: GatedResidual::new("residual", sizes.residual(), layout, values),
                output_gate: gate("output_gate"),
            }),
            output: linear("output", [c, sizes.outputs * sizes.quantiles]),
            sizes,
        }
    }

    /// Returns Δs of all steps.
    ///
    /// `rows` is what is known at a step, `fed_back` is Δs of the step and how it is known (1: measured, -1:
    /// predicted, 0: not at all): only later steps see it. If it was measured, the network predicts the change since
    /// then, provided its sizes say `carry`.
    ///
    /// # Shapes
    /// `rows: [steps, sequences, inputs]`, `fed_back: [steps, sequences, outputs + 1]` to `[steps, sequences, outputs ·
    /// quantiles]`.
    pub fn forward(&self, rows: &[f32], fed_back: &[f32], sequences: usize) -> (Vec<f32>, NetworkPass) {
        let SatSizes { inputs, outputs, width: c, .. } = self.sizes;
        let both = rows.chunks_exact(inputs).zip(fed_back.chunks_exact(outputs + 1));
        let past: Vec<f32> = both.flat_map(|(row, fed)| row.iter().chain(fed)).copied().collect();
        let (past, present) = (self.encoder.forward(past), self.decoder.forward(rows.to_vec()));
        let count = present.rows.len();
        let mut embedded = past.rows;
        embedded.extend(&present.rows);
        let (embedded, backbone) = match &self.backbone {
            Layers::None => (embedded, LayersPass::None),
            Layers::Dense(layers) => {
                let [first, second] = &**layers;
                let inner = rectified(first.forward(&embedded));
                let out = rectified(second.forward(&inner));
                (out.clone(), LayersPass::Dense([embedded, inner, out]))
            }
            Layers::Lstm(layers) => {
                let Recurrent { encoder, decoder, gate } = &**layers;
                let before = LstmState::zeros(sequences, c);
                let encoder = encoder.forward(embedded[..count].to_vec(), &before);
                let (hidden, cell) = encoder.states();
                // The present step goes on from what was remembered of the step before.
                let shifted = |states: &[f32]| [&before.hidden, &states[..count - sequences * c]].concat();
                let state = LstmState { hidden: shifted(hidden), cell: shifted(cell) };
                let decoder = decoder.forward(present.rows, &state);
                let outputs = [hidden, decoder.states().0].concat();
                let (out, gate) = gate.forward(outputs, &embedded);
                (out, LayersPass::Lstm { encoder, decoder, gate })
            }
        };
        let (last, attention) = match &self.attention {
            None => (embedded[count..].to_vec(), None),
            Some(layers) => {
                let present = &embedded[count..];
                let (mixed, pass) = layers.history.forward(embedded[..count].to_vec(), present.to_vec(), sequences);
                let (x, gate) = layers.gate.forward(mixed, present);
                let (x, residual) = layers.residual.forward(x);
                let (x, output_gate) = layers.output_gate.forward(x, present);
                (x, Some((pass, gate, residual, output_gate)))
            }
        };
        let mut out = self.output.forward(&last);
        let row = sequences * self.sizes.outputs * self.sizes.quantiles;
        if let Some(later) = out.get_mut(row..) {
            carry(self.sizes, fed_back, later);
        }
        let pass = NetworkPass { encoder: past.pass, decoder: present.pass, backbone, attention, last, sequences };
        (out, pass)
    }

    /// Adds the gradients of all parameters, from the one by what [`Self::forward`] returned.
    pub fn backward(&self, pass: NetworkPass, gradient: &[f32], sums: &mut [f32]) {
        let NetworkPass { encoder, decoder, backbone, attention, last, sequences } = pass;
        let (c, count) = (self.sizes.width, last.len());
        let by_last = self.output.backward(&last, gradient, sums);
        let by_embedded = match (&self.attention, attention) {
            (Some(layers), Some((pass, gate, residual, output_gate))) => {
                let (by_x, mut by_present) = layers.output_gate.backward(output_gate, &by_last, sums);
                let by_x = layers.residual.backward(residual, &by_x, sums);
                let (by_mixed, by_skip) = layers.gate.backward(gate, &by_x, sums);
                add(&mut by_present, &by_skip);
                let (by_past, by_query) = layers.history.backward(pass, &by_mixed, sums);
                add(&mut by_present, &by_query);
                [by_past, by_present].concat()
            }
            _ => [vec![0.0; count], by_last].concat(),
        };
        let by_selected = match (&self.backbone, backbone) {
            (Layers::Dense(layers), LayersPass::Dense([x, inner, out])) => {
                let [first, second] = &**layers;
                let by_inner = second.backward(&inner, &through_rectifier(by_embedded, &out), sums);
                first.backward(&x, &through_rectifier(by_inner, &inner), sums)
            }
            (Layers::Lstm(layers), LayersPass::Lstm { encoder: past, decoder: present, gate: pass }) => {
                let Recurrent { encoder, decoder, gate } = &**layers;
                let (by_hidden, mut by_selected) = gate.backward(pass, &by_embedded, sums);
                let (by_past, by_present) = by_hidden.split_at(count);
                let (by_row, by_state) = decoder.backward(present, (by_present, &[]), sums);
                add(&mut by_selected[count..], &by_row);
                // What the present step began with is what was remembered one step before.
                let shifted = |by: &[f32]| [&by[sequences * c..], &vec![0.0; sequences * c]].concat();
                let (mut by_hidden, by_cell) = (shifted(&by_state.hidden), shifted(&by_state.cell));
                add(&mut by_hidden, by_past);
                let (by_row, _) = encoder.backward(past, (&by_hidden, &by_cell), sums);
                add(&mut by_selected[..count], &by_row);
                by_selected
            }
            _ => by_embedded,
        };
        self.encoder.backward(encoder, &by_selected[..count], sums);
        self.decoder.backward(decoder, &by_selected[count..], sums);
    }

    /// Returns the mean weight of each history step in a pass, from the latest to the oldest, and last the present one's own
    /// (Fig. 2.11); none without attention.
    pub fn profile(&self, pass: &NetworkPass) -> Option<Vec<f64>> {
        let (layers, (pass, ..)) = (self.attention.as_ref()?, pass.attention.as_ref()?);
        Some(layers.history.profile(pass))
    }
}

/// Adds the measured errors of rows to predictions for the rows after them; those that were not measured are left out.
pub(super) fn carry(sizes: SatSizes, fed_back: &[f32], out: &mut [f32]) {
    let SatSizes { outputs, quantiles, carry, .. } = sizes;
    if !carry {
        return;
    }
    for (fed, out) in fed_back.chunks_exact(outputs + 1).zip(out.chunks_exact_mut(outputs * quantiles)) {
        let measured = fed[outputs].max(0.0);
        for (x, out) in fed.iter().zip(out.chunks_exact_mut(quantiles)) {
            out.iter_mut().for_each(|out| *out += measured * x);
        }
    }
}

pub(super) fn rectified(mut x: Vec<f32>) -> Vec<f32> {
    x.iter_mut().for_each(|x| *x = x.max(0.0));
    x
}

/// The gradient by what a rectifier was given, from its output.
fn through_rectifier(mut gradient: Vec<f32>, out: &[f32]) -> Vec<f32> {
    gradient.iter_mut().zip(out).filter(|(_, out)| **out <= 0.0).for_each(|(gradient, _)| *gradient = 0.0);
    gradient
}
