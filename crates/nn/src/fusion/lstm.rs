//! Long short-term memory (Hochreiter & Schmidhuber 1997), as PyTorch's `LSTM`.

use std::ops::Range;

use lifelike_simd::vectorize;

use super::elementary::{sigmoid, tanh};
use crate::rows::{Entry, Init, Layout, PackedWeight, add, bias_gradient, weight_gradient};

/// i, f, g, o = x W + h U + b; c ← σ(f) c + σ(i) tanh(g); h ← σ(o) tanh(c).
#[derive(Debug, Clone)]
pub struct Lstm {
    /// Places of input, recurrent and bias in rows of gradients.
    places: [Range<usize>; 3],
    inputs: usize,
    width: usize,
    input: PackedWeight,
    recurrent: PackedWeight,
    bias: Vec<f32>,
}

/// Memory, one row for each sequence.
#[derive(Debug, Clone, PartialEq)]
pub struct LstmState {
    /// h, `[sequences, width]`.
    pub hidden: Vec<f32>,
    /// c, `[sequences, width]`.
    pub cell: Vec<f32>,
}

impl LstmState {
    /// Nothing.
    pub fn zeros(sequences: usize, width: usize) -> Self {
        let zeros = vec![0.0; sequences * width];
        Self { hidden: zeros.clone(), cell: zeros }
    }
}

/// Numbers that the way back needs.
#[derive(Debug, Clone)]
pub struct LstmPass {
    x: Vec<f32>,
    /// The activated gates of all steps, `[steps, sequences, 4 width]`.
    gates: Vec<f32>,
    /// h of all steps, that before the first included, `[steps + 1, sequences, width]`.
    hidden: Vec<f32>,
    /// c likewise.
    cell: Vec<f32>,
}

impl LstmPass {
    /// Returns what was remembered after each step, h and c, `[steps, sequences, width]`.
    pub fn states(&self) -> (&[f32], &[f32]) {
        let sequences = self.hidden.len() - self.gates.len() / 4;
        (&self.hidden[sequences..], &self.cell[sequences..])
    }
}

impl Lstm {
    /// Returns its parameters: `NAME.input` `[inputs, 4 width]`, `NAME.recurrent` `[width, 4 width]` and `NAME.bias`, with
    /// PyTorch's initial values. (PyTorch has two biases, whose sum is this one.)
    pub fn entries(name: &str, inputs: usize, width: usize) -> Vec<Entry> {
        let init = Init::Uniform((width.max(1) as f64).powf(-0.5));
        let entry = |part: &str, shape: Vec<usize>| Entry { name: format!("{name}.{part}"), shape, init };
        vec![
            entry("input", vec![inputs, 4 * width]),
            entry("recurrent", vec![width, 4 * width]),
            entry("bias", vec![4 * width]),
        ]
    }

    /// Packs parameters that stand as the layout says.
    pub fn new(name: &str, inputs: usize, width: usize, layout: &Layout, values: &[f32]) -> Self {
        let places = ["input", "recurrent", "bias"].map(|part| layout.range(&format!("{name}.{part}")));
        let [input, recurrent, bias] = places.clone().map(|place| &values[place]);
        Self {
            places,
            inputs,
            width,
            input: PackedWeight::new(input, [inputs, 4 * width]),
            recurrent: PackedWeight::new(recurrent, [width, 4 * width]),
            bias: bias.to_vec(),
        }
    }

    /// Goes forward through all steps.
    ///
    /// # Shapes
    /// `x: [steps, sequences, inputs]`; what is remembered after each step is in [`LstmPass::states`].
    pub fn forward(&self, x: Vec<f32>, before: &LstmState) -> LstmPass {
        let (c, rows) = (self.width, before.hidden.len());
        let mut gates = self.input.forward(&x, &self.bias);
        let (mut hidden, mut cell) = (before.hidden.clone(), before.cell.clone());
        hidden.reserve(gates.len() / 4);
        cell.reserve(gates.len() / 4);
        for gates in gates.chunks_exact_mut((4 * rows).max(1)) {
            let before = hidden.len() - rows;
            add(gates, &self.recurrent.forward(&hidden[before..], &[]));
            hidden.resize(hidden.len() + rows, 0.0);
            cell.resize(cell.len() + rows, 0.0);
            let (old, new) = cell[before..].split_at_mut(rows);
            let hidden = &mut hidden[before + rows..];
            vectorize(
                #[inline(always)]
                || {
                    let memory = old.chunks_exact(c).zip(new.chunks_exact_mut(c)).zip(hidden.chunks_exact_mut(c));
                    for (gates, ((old, new), hidden)) in gates.chunks_exact_mut(4 * c).zip(memory) {
                        let (input, rest) = gates.split_at_mut(c);
                        let (forget, rest) = rest.split_at_mut(c);
                        let (candidate, output) = rest.split_at_mut(c);
                        for i in 0..c {
                            input[i] = sigmoid(input[i]);
                            forget[i] = sigmoid(forget[i]);
                            candidate[i] = tanh(candidate[i]);
                            output[i] = sigmoid(output[i]);
                            new[i] = forget[i] * old[i] + input[i] * candidate[i];
                            hidden[i] = output[i] * tanh(new[i]);
                        }
                    }
                },
            );
        }
        LstmPass { x, gates, hidden, cell }
    }

    /// Adds the parameters' gradients, from those by h and c of all steps (`[steps, sequences, width]`, c's may be empty).
    /// Returns the gradient by x, and by what was remembered before the first step.
    pub fn backward(
        &self,
        pass: LstmPass,
        (by_hidden, by_cell): (&[f32], &[f32]),
        sums: &mut [f32],
    ) -> (Vec<f32>, LstmState) {
        let LstmPass { x, mut gates, hidden, cell } = pass;
        let c = self.width;
        let rows = hidden.len() - gates.len() / 4;
        let steps = gates.len() / (4 * rows).max(1);
        let mut state = LstmState { hidden: vec![0.0; rows], cell: vec![0.0; rows] };
        for step in (0..steps).rev() {
            let own: Range<usize> = step * rows..(step + 1) * rows;
            add(&mut state.hidden, &by_hidden[own.clone()]);
            if !by_cell.is_empty() {
                add(&mut state.cell, &by_cell[own.clone()]);
            }
            let (old, new) = (&cell[own.clone()], &cell[own.start + rows..own.end + rows]);
            let gates = &mut gates[4 * own.start..4 * own.end];
            let LstmState { hidden: by_hidden, cell: by_cell } = &mut state;
            vectorize(
                #[inline(always)]
                || {
                    let memory = old.chunks_exact(c).zip(new.chunks_exact(c));
                    let by = by_hidden.chunks_exact(c).zip(by_cell.chunks_exact_mut(c));
                    for (gates, ((old, new), (by_hidden, by_cell))) in gates.chunks_exact_mut(4 * c).zip(memory.zip(by))
                    {
                        let (input, rest) = gates.split_at_mut(c);
                        let (forget, rest) = rest.split_at_mut(c);
                        let (candidate, output) = rest.split_at_mut(c);
                        for i in 0..c {
                            let shown = tanh(new[i]);
                            let by_new = by_cell[i] + by_hidden[i] * output[i] * (1.0 - shown * shown);
                            let (i_gate, f_gate, g, o_gate) = (input[i], forget[i], candidate[i], output[i]);
                            output[i] = by_hidden[i] * shown * o_gate * (1.0 - o_gate);
                            input[i] = by_new * g * i_gate * (1.0 - i_gate);
                            forget[i] = by_new * old[i] * f_gate * (1.0 - f_gate);
                            candidate[i] = by_new * i_gate * (1.0 - g * g);
                            by_cell[i] = by_new * f_gate;
                        }
                    }
                },
            );
            state.hidden = self.recurrent.by_input(gates);
        }
        let [input, recurrent, bias] = self.places.clone();
        let before = &hidden[..steps * rows];
        weight_gradient(before, &gates, [c, 4 * c], &mut sums[recurrent]);
        weight_gradient(&x, &gates, [self.inputs, 4 * c], &mut sums[input]);
        bias_gradient(&gates, &mut sums[bias]);
        (self.input.by_input(&gates), state)
    }
}
