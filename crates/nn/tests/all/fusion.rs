//! The blocks of the Temporal Fusion Transformer against PyTorch (`fixtures/make_fusion.py`), forward and backward.

use crate::fixture::Fixture;
use lifelike_nn::fusion::{
    GateAddNorm, GatedResidual, GatedResidualSizes, HistoryAttention, HistorySizes, Lstm, LstmState, SelectionSizes,
    VariableSelection,
};
use lifelike_nn::rows::{Entry, Layout};

/// The fixture with the parameters of one block.
struct Block {
    fixture: Fixture,
    layout: Layout,
    values: Vec<f32>,
    sums: Vec<f32>,
}

impl Block {
    fn new(entries: Vec<Entry>) -> Self {
        let (fixture, layout) = (Fixture::read(include_str!("../fixtures/fusion.json")), Layout::new(entries));
        let values: Vec<f32> = layout.entries().iter().flat_map(|entry| fixture.f32s(&entry.name)).collect();
        assert_eq!(values.len(), layout.len());
        Self { sums: vec![0.0; values.len()], fixture, layout, values }
    }

    fn parameters_are_close(&self) {
        for entry in self.layout.entries() {
            self.fixture.close(&format!("d.{}", entry.name), &self.sums[self.layout.range(&entry.name)]);
        }
    }
}

#[test]
fn a_gate_beside_a_skip_connection() {
    let mut b = Block::new(GateAddNorm::entries("gate", 7, 5));
    let block = GateAddNorm::new("gate", 7, 5, &b.layout, &b.values);
    let (y, pass) = block.forward(b.fixture.f32s("gate.x"), &b.fixture.f32s("gate.skip"));
    b.fixture.close("gate.y", &y);
    let (by_x, by_skip) = block.backward(pass, &b.fixture.f32s("gate.dy"), &mut b.sums);
    b.fixture.close("gate.d.x", &by_x);
    b.fixture.close("gate.d.skip", &by_skip);
    b.parameters_are_close();
}

#[test]
fn a_gated_residual_network_with_and_without_a_map_of_its_skip_connection() {
    for (name, outputs) in [("residual", 6), ("resized", 4)] {
        let sizes = GatedResidualSizes { inputs: 6, hidden: 10, outputs };
        let mut b = Block::new(GatedResidual::entries(name, sizes));
        let block = GatedResidual::new(name, sizes, &b.layout, &b.values);
        let (y, pass) = block.forward(b.fixture.f32s(&format!("{name}.x")));
        b.fixture.close(&format!("{name}.y"), &y);
        let by_x = block.backward(pass, &b.fixture.f32s(&format!("{name}.dy")), &mut b.sums);
        b.fixture.close(&format!("{name}.d.x"), &by_x);
        b.parameters_are_close();
    }
}

#[test]
fn a_variable_selection_network_and_its_weights() {
    let sizes = SelectionSizes { variables: 5, embedding: 3, width: 20 };
    let mut b = Block::new(VariableSelection::entries("selection", sizes));
    let block = VariableSelection::new("selection", sizes, &b.layout, &b.values);
    let selected = block.forward(b.fixture.f32s("selection.x"));
    b.fixture.close("selection.weights", &selected.weights);
    b.fixture.close("selection.y", &selected.rows);
    let by_x = block.backward(selected.pass, &b.fixture.f32s("selection.dy"), &mut b.sums);
    b.fixture.close("selection.d.x", &by_x);
    b.parameters_are_close();
}

#[test]
fn long_short_term_memory_is_pytorchs() {
    let (inputs, width, sequences, steps) = (4, 17, 3, 6);
    let mut b = Block::new(Lstm::entries("lstm", inputs, width));
    let block = Lstm::new("lstm", inputs, width, &b.layout, &b.values);
    let before = LstmState { hidden: b.fixture.f32s("lstm.h"), cell: b.fixture.f32s("lstm.c") };
    let pass = block.forward(b.fixture.f32s("lstm.x"), &before);
    let (hidden, cell) = pass.states();
    b.fixture.close("lstm.y", hidden);
    let last = (steps - 1) * sequences * width;
    b.fixture.close("lstm.last_cell", &cell[last..]);
    let mut by_cell = vec![0.0; cell.len()];
    by_cell[last..].copy_from_slice(&b.fixture.f32s("lstm.by_cell"));
    let (by_x, by_before) = block.backward(pass, (&b.fixture.f32s("lstm.dy"), &by_cell), &mut b.sums);
    b.fixture.close("lstm.d.x", &by_x);
    b.fixture.close("lstm.d.h", &by_before.hidden);
    b.fixture.close("lstm.d.c", &by_before.cell);
    b.parameters_are_close();
}

/// Thirty steps, twenty of them looked back on: windows that grow, windows that slide, lengths beyond whole vectors.
#[test]
fn attention_over_the_history() {
    let sizes = HistorySizes { width: 8, heads: 2, steps: 20 };
    let mut b = Block::new(HistoryAttention::entries("attention", sizes));
    let block = HistoryAttention::new("attention", sizes, &b.layout, &b.values);
    let (past, present) = (b.fixture.f32s("attention.past"), b.fixture.f32s("attention.present"));
    let (y, pass) = block.forward(past.clone(), present.clone(), 2);
    b.fixture.close("attention.y", &y);
    let profile: Vec<f32> = block.profile(&pass).iter().map(|w| *w as f32).collect();
    b.fixture.close("attention.profile", &profile);
    let (by_past, by_present) = block.backward(pass, &b.fixture.f32s("attention.dy"), &mut b.sums);
    b.fixture.close("attention.d.past", &by_past);
    b.fixture.close("attention.d.present", &by_present);
    for entry in b.layout.entries() {
        let got = &b.sums[b.layout.range(&entry.name)];
        // What all keys have in common changes no weight.
        if entry.name == "attention.key.bias" {
            assert!(got.iter().all(|x| x.abs() < 1e-4), "{got:?}");
        } else {
            b.fixture.close(&format!("d.{}", entry.name), got);
        }
    }

    // Step by step it is the same.
    let remembered = block.remember(&past);
    for t in 0..30_usize {
        let window = t.saturating_sub(20)..t;
        let got = block.step(&present[t * 16..(t + 1) * 16], |row| {
            let remembered = &remembered;
            window.clone().map(move |t| {
                let i = 2 * t + row;
                (&remembered.key[i * 8..][..8], &remembered.value[i * 4..][..4])
            })
        });
        assert!(got.iter().zip(&y[t * 16..]).all(|(a, b)| (a - b).abs() < 1e-5), "step {t}: {got:?}");
    }
}
