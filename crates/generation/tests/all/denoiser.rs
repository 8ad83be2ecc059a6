//! The denoiser against PyTorch (`fixtures/make_denoiser.py`).

use std::collections::BTreeMap;

use lifelike_generation::denoiser::{Denoiser, DenoiserInput, DenoiserSizes, TextInput};
use lifelike_nn::transformer::encoder::EncoderSizes;

const SIZES: DenoiserSizes = DenoiserSizes {
    encoder: EncoderSizes { width: 8, layers: 1, heads: 2, inner: 12 },
    motion: 5,
    text: TextInput { pieces: 6 },
    duration: true,
};

fn fixture() -> BTreeMap<String, Vec<f64>> {
    serde_json::from_str(include_str!("../fixtures/denoiser.json")).unwrap()
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
    let (prompt, motions) = ([3, 1, 3], [single(&f["0.motion"]), single(&f["1.motion"])]);
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

#[test]
fn what_does_not_fit_is_refused() {
    let layout = SIZES.layout().unwrap();
    let denoiser = Denoiser::new(SIZES, &layout, &layout.init(0, "test"));
    let error = |motion: &[f32], condition: Option<&[u32]>| {
        denoiser.forward(&[DenoiserInput { motion, step: 0, condition }]).unwrap_err().to_string()
    };
    assert!(error(&[], None).contains("tokens of 5 numbers"));
    assert!(error(&[0.0; 7], None).contains("got 7"));
    assert!(error(&[0.0; 5], Some(&[6])).contains("below 6"));
    assert!(DenoiserSizes { encoder: EncoderSizes { heads: 3, ..SIZES.encoder }, ..SIZES }.layout().is_err());
}
