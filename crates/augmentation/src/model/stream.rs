//! The network step by step, for a running simulation.

use std::collections::VecDeque;

use lifelike_nn::fusion::LstmState;

use super::network::{Layers, Network, Recurrent, carry, rectified};
use super::sizes::SatSizes;

/// A network that goes on from records of the steps before, many independent rows at once.
///
/// A step's record is what later steps need of it: what the LSTM remembers, a key and a value, and what was fed back. The first step has none: the error is
/// taken to be zero there (thesis 2.4).
#[derive(Debug, Clone)]
pub struct Stream {
    network: Network,
}

impl Stream {
    /// Streams a network.
    pub fn new(network: Network) -> Self {
        Self { network }
    }

    /// Returns the numbers of one step's record.
    pub fn record_width(&self) -> usize {
        let SatSizes { width: c, heads, outputs, .. } = self.network.sizes;
        3 * c + c / heads + outputs + 1
    }

    /// Returns the number of records that are looked back on.
    pub fn history(&self) -> usize {
        if self.network.attention.is_some() { self.network.sizes.history } else { 1 }
    }

    /// Returns Δs of the present step.
    ///
    /// # Shapes
    /// `rows: [rows, inputs]`; `past(row)` gives that row's records, the oldest first, at most [`Self::history`]; to `[rows,
    /// outputs · quantiles]`.
    pub fn predict<'a, I>(&self, rows: &[f32], past: impl Fn(usize) -> I) -> Vec<f32>
    where
        I: DoubleEndedIterator<Item = &'a [f32]>,
    {
        let (network, c) = (&self.network, self.network.sizes.width);
        let d = c / network.sizes.heads;
        let count = rows.len() / network.sizes.inputs.max(1);
        let selected = network.decoder.select(rows);
        let present = match &network.backbone {
            Layers::None => selected,
            Layers::Dense(layers) => {
                let [first, second] = &**layers;
                rectified(second.forward(&rectified(first.forward(&selected))))
            }
            Layers::Lstm(layers) => {
                let Recurrent { decoder, gate, .. } = &**layers;
                let state = self.remembered(count, &past);
                let pass = decoder.forward(selected.clone(), &state);
                gate.forward(pass.states().0.to_vec(), &selected).0
            }
        };
        let last = match &network.attention {
            None => present,
            Some(layers) => {
                let mixed = layers.history.step(&present, |row| {
                    past(row).map(move |record| (&record[2 * c..3 * c], &record[3 * c..3 * c + d]))
                });
                let x = layers.gate.forward(mixed, &present).0;
                let x = layers.residual.forward(x).0;
                layers.output_gate.forward(x, &present).0
            }
        };
        let mut out = network.output.forward(&last);
        let (numbers, fed) = (network.sizes.outputs * network.sizes.quantiles, network.sizes.outputs + 1);
        for (row, out) in out.chunks_exact_mut(numbers).enumerate() {
            if let Some(record) = past(row).next_back() {
                carry(network.sizes, &record[record.len() - fed..], out);
            }
        }
        out
    }

    /// Writes the present step's records, now that Δs of it is known, or taken to be.
    ///
    /// # Shapes
    /// `rows: [rows, inputs]`, `fed_back: [rows, outputs + 1]`, `records: [rows, record width]`.
    pub fn remember<'a, I>(&self, rows: &[f32], fed_back: &[f32], past: impl Fn(usize) -> I, records: &mut [f32])
    where
        I: DoubleEndedIterator<Item = &'a [f32]>,
    {
        let SatSizes { inputs, outputs, width: c, heads, .. } = self.network.sizes;
        let both = rows.chunks_exact(inputs).zip(fed_back.chunks_exact(outputs + 1));
        let x: Vec<f32> = both.flat_map(|(row, fed)| row.iter().chain(fed)).copied().collect();
        let count = rows.len() / inputs.max(1);
        let selected = self.network.encoder.select(&x);
        let mut state = LstmState::zeros(count, c);
        let embedded = match &self.network.backbone {
            Layers::None => selected,
            Layers::Dense(layers) => {
                let [first, second] = &**layers;
                rectified(second.forward(&rectified(first.forward(&selected))))
            }
            Layers::Lstm(layers) => {
                let Recurrent { encoder, gate, .. } = &**layers;
                let pass = encoder.forward(selected.clone(), &self.remembered(count, &past));
                let (hidden, cell) = pass.states();
                state = LstmState { hidden: hidden.to_vec(), cell: cell.to_vec() };
                gate.forward(hidden.to_vec(), &selected).0
            }
        };
        let kept = self.network.attention.as_ref().map(|layers| layers.history.remember(&embedded));
        for (row, record) in records.chunks_exact_mut(self.record_width()).enumerate() {
            record[..c].copy_from_slice(&state.hidden[row * c..][..c]);
            record[c..2 * c].copy_from_slice(&state.cell[row * c..][..c]);
            let first = record.len() - outputs - 1;
            record[first..].copy_from_slice(&fed_back[row * (outputs + 1)..][..outputs + 1]);
            if let Some(kept) = &kept {
                record[2 * c..3 * c].copy_from_slice(&kept.key[row * c..][..c]);
                record[3 * c..3 * c + c / heads].copy_from_slice(&kept.value[row * (c / heads)..][..c / heads]);
            }
        }
    }

    fn remembered<'a, I>(&self, count: usize, past: &impl Fn(usize) -> I) -> LstmState
    where
        I: DoubleEndedIterator<Item = &'a [f32]>,
    {
        let c = self.network.sizes.width;
        let mut state = LstmState::zeros(count, c);
        for row in 0..count {
            if let Some(record) = past(row).next_back() {
                state.hidden[row * c..][..c].copy_from_slice(&record[..c]);
                state.cell[row * c..][..c].copy_from_slice(&record[c..2 * c]);
            }
        }
        state
    }
}

/// A network that runs over some rows from their first step on: records of the last steps are its own.
#[derive(Debug, Clone)]
pub struct ClosedLoop {
    stream: Stream,
    /// `[steps][rows, record width]`, the oldest first.
    records: VecDeque<Vec<f32>>,
    rows: usize,
}

impl ClosedLoop {
    /// Begins with `rows` rows that have no past.
    pub fn new(network: Network, rows: usize) -> Self {
        Self { stream: Stream::new(network), records: VecDeque::new(), rows }
    }

    /// As [`Stream::predict`].
    pub fn predict(&self, rows: &[f32]) -> Vec<f32> {
        self.stream.predict(rows, |row| self.past(row))
    }

    /// Ends a step, as [`Stream::remember`].
    pub fn remember(&mut self, rows: &[f32], fed_back: &[f32]) {
        let mut record = vec![0.0; self.rows * self.stream.record_width()];
        self.stream.remember(rows, fed_back, |row| self.past(row), &mut record);
        if self.records.len() == self.stream.history() {
            self.records.pop_front();
        }
        self.records.push_back(record);
    }

    fn past(&self, row: usize) -> impl DoubleEndedIterator<Item = &[f32]> {
        let width = self.stream.record_width();
        self.records.iter().map(move |record| &record[row * width..][..width])
    }
}

/// Runs sequences side by side, each step fed the predictions of the steps before, and returns these.
///
/// `predictions` makes Δs of the network's numbers of a step, `[rows, outputs]`, and `known` stands beside what is fed back. A sequence that has ended
/// keeps its last row, and its predictions are left out.
///
/// # Shapes
/// `rows: [steps, inputs]` of each sequence to `[steps, outputs]` of each.
pub fn closed_loop(
    network: &Network,
    rows: &[&[f32]],
    known: f32,
    predictions: impl Fn(Vec<f32>) -> Vec<f32>,
) -> Vec<Vec<f32>> {
    let (width, outputs) = (network.sizes.inputs, network.sizes.outputs);
    let mut closed = ClosedLoop::new(network.clone(), rows.len());
    let mut out = vec![Vec::new(); rows.len()];
    for step in 0..rows.iter().map(|own| own.len() / width).max().unwrap_or(0) {
        let at = |own: &&[f32]| {
            let last = (own.len() / width).saturating_sub(1);
            own.get(step.min(last) * width..)
                .and_then(|rest| rest.get(..width))
                .map_or(vec![0.0; width], <[f32]>::to_vec)
        };
        let present: Vec<f32> = rows.iter().flat_map(at).collect();
        let predicted = predictions(closed.predict(&present));
        let fed: Vec<f32> = predicted.chunks_exact(outputs).flat_map(|own| [own, &[known]].concat()).collect();
        closed.remember(&present, &fed);
        for ((out, own), rows) in out.iter_mut().zip(predicted.chunks_exact(outputs)).zip(rows) {
            if step < rows.len() / width {
                out.extend_from_slice(own);
            }
        }
    }
    out
}
