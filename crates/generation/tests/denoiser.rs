//! The denoiser against PyTorch (`fixtures/make_denoiser.py`).

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use lifelike_generation::denoiser::{Denoiser, DenoiserInput, DenoiserSizes, TextInput};
use lifelike_generation::text::{Condition, TextTokens};
use lifelike_nn::transformer::encoder::EncoderSizes;

const SIZES: DenoiserSizes = DenoiserSizes {
    encoder: EncoderSizes { width: 8, layers: 1, heads: 2, inner: 12 },
    motion: 5,
    text: TextInput::Pieces(6),
    duration: true,
};

fn fixture() -> BTreeMap<String, Vec<f64>> {
    serde_json::from_str(include_str!("fixtures/denoiser.json")).unwrap()
}

fn single(numbers: &[f64]) -> Vec<f32> {
    numbers.iter().map(|x| *x as f32).collect()
}

/// Within 1e-5 of the largest: both are sums of some dozens of single-precision numbers.
fn close(name: &str, got: &[f32], expected: &[f64]) {
    assert_eq!(got.len(), expected.len(), "{name}");
    // Some gradients are 0 up to rounding (the keys' bias).
    let scale = expected.iter().fold(0.1_f64, |m, x| m.max(x.abs()));
    for (a, b) in got.iter().zip(expected) {
        assert!((f64::from(*a) - b).abs() <= 1e-5 * scale, "{name}: {a} {b} at {scale}");
    }
}

#[test]
fn a_motion_with_a_prompt_and_one_without_are_pytorchs() {
    let f = fixture();
    let layout = SIZES.layout().unwrap();
    let values: Vec<f32> = layout.entries().iter().flat_map(|entry| single(&f[&entry.name])).collect();
    let denoiser = Denoiser::new(SIZES, &layout, &values);
    let (prompt, motions) = (Condition::Pieces(vec![3, 1, 3]), [single(&f["0.motion"]), single(&f["1.motion"])]);
    let inputs = [
        DenoiserInput { motion: &motions[0], step: 17, condition: Some(&prompt) },
        DenoiserInput { motion: &motions[1], step: 900, condition: None },
    ];
    let (clean, pass) = denoiser.forward(&inputs).unwrap();
    close("y", &clean, &[f["0.y"].clone(), f["1.y"].clone()].concat());
    let mut sums = vec![0.0; layout.len()];
    let gradient = single(&[f["0.dy"].clone(), f["1.dy"].clone()].concat());
    denoiser.backward(pass, &gradient, &layout, &mut sums);
    for entry in layout.entries() {
        close(&entry.name, &sums[layout.range(&entry.name)], &f[&format!("d.{}", entry.name)]);
    }
}

/// The linear map of embedded tokens is the table where tokens are unit vectors.
#[test]
fn embedded_tokens_are_read_as_pieces_are() {
    let (table, linear) = (SIZES, DenoiserSizes { text: TextInput::Embedded(6), ..SIZES });
    let (by_table, by_linear) = (table.layout().unwrap(), linear.layout().unwrap());
    let values = by_table.init(1, "test");
    let mut other = by_linear.init(2, "test");
    for entry in by_linear.entries() {
        let from = match entry.name.as_str() {
            "text.weight" => "text.table",
            name => name,
        };
        match entry.name.as_str() {
            "text.bias" => other[by_linear.range("text.bias")].fill(0.0),
            name => other[by_linear.range(name)].copy_from_slice(&values[by_table.range(from)]),
        }
    }
    let motion: Vec<f32> = (0..15).map(|i| (i as f32).sin()).collect();
    let unit = |id: usize| (0..6).map(move |i| if i == id { 1.0 } else { 0.0 });
    let prompts = [
        Condition::Pieces(vec![2, 5]),
        Condition::Embedded(TextTokens { width: 6, numbers: unit(2).chain(unit(5)).collect() }),
    ];
    let clean = |sizes, layout, values: &[f32], prompt| {
        let input = DenoiserInput { motion: &motion, step: 3, condition: Some(prompt) };
        let denoiser = Denoiser::new(sizes, layout, values);
        let (clean, pass) = denoiser.forward(&[input]).unwrap();
        let mut sums = vec![0.0; layout.len()];
        denoiser.backward(pass, &clean, layout, &mut sums);
        (clean, sums)
    };
    let (a, by_a) = clean(table, &by_table, &values, &prompts[0]);
    let (b, by_b) = clean(linear, &by_linear, &other, &prompts[1]);
    assert_eq!(a, b);
    assert_eq!(by_a[by_table.range("text.table")], by_b[by_linear.range("text.weight")]);
}

#[test]
fn what_does_not_fit_is_refused() {
    let layout = SIZES.layout().unwrap();
    let denoiser = Denoiser::new(SIZES, &layout, &layout.init(0, "test"));
    let error = |motion: &[f32], condition: Option<&Condition>| {
        denoiser.forward(&[DenoiserInput { motion, step: 0, condition }]).unwrap_err().to_string()
    };
    assert!(error(&[], None).contains("tokens of 5 numbers"));
    assert!(error(&[0.0; 7], None).contains("got 7"));
    assert!(error(&[0.0; 5], Some(&Condition::Pieces(vec![6]))).contains("below 6"));
    let embedded = Condition::Embedded(TextTokens { width: 384, numbers: vec![0.0; 384] });
    assert!(error(&[0.0; 5], Some(&embedded)).contains("384"));
    assert!(DenoiserSizes { encoder: EncoderSizes { heads: 3, ..SIZES.encoder }, ..SIZES }.layout().is_err());
}
