//! The encoder against PyTorch's `TransformerEncoderLayer` (`fixtures/make_encoder.py`, float64 with padding and a
//! mask).

use crate::fixture::Fixture;
use lifelike_nn::rows::Layout;
use lifelike_nn::transformer::NetworkError;
use lifelike_nn::transformer::encoder::{Encoder, EncoderSizes};

const SIZES: EncoderSizes = EncoderSizes { width: 12, layers: 2, heads: 3, inner: 20 };

fn layout() -> Layout {
    Layout::new(SIZES.entries("encoder").unwrap())
}

#[test]
fn sequences_of_two_lengths_are_those_of_a_padded_batch_with_a_mask() {
    let f = Fixture::read(include_str!("../fixtures/encoder.json"));
    let layout = layout();
    let values: Vec<f32> = layout.entries().iter().flat_map(|entry| f.f32s(&entry.name)).collect();
    assert_eq!(values.len(), layout.len());
    let encoder = Encoder::new(SIZES, &layout, "encoder", &values);
    let (y, pass) = encoder.forward(f.f32s("x"), &[7, 4]);
    f.close("y", &y);
    let mut sums = vec![0.0; layout.len()];
    let by_x = encoder.backward(pass, f.f32s("dy"), &mut sums);
    f.close("d.x", &by_x);
    for entry in layout.entries() {
        let (name, got) = (format!("d.{}", entry.name), &sums[layout.range(&entry.name)]);
        if entry.name.ends_with("projection.bias") {
            // The bias of the keys has no effect: its gradient is 0, here up to rounding of sums of numbers around 1.
            let expected = f.data(&name);
            assert!(got.iter().zip(expected).all(|(a, b)| (f64::from(*a) - b).abs() < 2e-5), "{got:?} {expected:?}");
        } else {
            f.close(&name, got);
        }
    }
}

#[test]
fn gradients_are_added_and_sequences_do_not_see_each_other() {
    let layout = layout();
    let values = layout.init(3, "test");
    let encoder = Encoder::new(SIZES, &layout, "encoder", &values);
    let x: Vec<f32> = (0..150 * 12).map(|i| (i as f32 * 0.37).sin()).collect();
    // Rows beyond a block and a panel.
    let (both, _) = encoder.forward(x.clone(), &[113, 37]);
    let (first, pass) = encoder.forward(x[..113 * 12].to_vec(), &[113]);
    let (second, _) = encoder.forward(x[113 * 12..].to_vec(), &[37]);
    assert_eq!(both, [first.clone(), second].concat(), "bit for bit");
    let mut once = vec![0.0; layout.len()];
    encoder.backward(pass.clone(), first.clone(), &mut once);
    let mut twice = once.clone();
    encoder.backward(pass, first, &mut twice);
    assert!(once.iter().zip(&twice).all(|(a, b)| (2.0 * a - b).abs() <= 1e-5 * a.abs().max(1.0)));
}

#[test]
fn initial_values_are_pytorchs_and_addressed_by_name() {
    let layout = layout();
    let values = layout.init(3, "test");
    let of = |name: &str| values[layout.range(name)].to_vec();
    let most = |name: &str| of(name).iter().fold(0.0_f32, |m, x| m.max(x.abs()));
    let bound = (6.0_f32 / 48.0).sqrt();
    let projection = most("encoder.0.attention.projection.weight");
    assert!(projection <= bound && projection > 0.9 * bound, "{projection} {bound}");
    assert!(most("encoder.1.feed_forward.outer.weight") <= 20.0_f32.powf(-0.5));
    assert_eq!(most("encoder.0.attention.output.bias"), 0.0);
    assert_eq!(of("encoder.0.norm_1.gain"), [1.0; 12]);
    assert_eq!(layout.init(3, "test"), values);
    assert_ne!(layout.init(4, "test"), values);
    assert!(layout.range("none").is_empty());
}

#[test]
fn sizes_that_make_no_encoder_are_refused() {
    let error = |sizes: EncoderSizes| sizes.entries("encoder").unwrap_err();
    assert_eq!(error(EncoderSizes { heads: 5, ..SIZES }), NetworkError::Heads { heads: 5, width: 12 });
    assert_eq!(error(EncoderSizes { inner: 0, ..SIZES }), NetworkError::Zero("inner"));
    assert_eq!(error(EncoderSizes { layers: 0, ..SIZES }), NetworkError::Zero("layers"));
}
