//! The whole network against PyTorch (`fixtures/make_sat.py`, which takes `peers/augmentation/sat.py`), and step by step against
//! itself.

use std::collections::BTreeMap;

use lifelike_augmentation::model::{Backbone, ClosedLoop, Network, SatSizes, Stream};

const SEQUENCES: usize = 2;
const KINDS: [(&str, Backbone, bool); 4] = [
    ("lstm_attention", Backbone::Lstm, true),
    ("lstm", Backbone::Lstm, false),
    ("dense_attention", Backbone::Dense, true),
    ("attention", Backbone::None, true),
];

fn sizes(backbone: Backbone, attention: bool) -> SatSizes {
    let kind = SatSizes { backbone, attention, ..SatSizes::default() };
    SatSizes { inputs: 3, outputs: 2, quantiles: 1, embedding: 2, width: 6, heads: 2, history: 5, ..kind }
}

struct Fixture(BTreeMap<String, Vec<f64>>);

impl Fixture {
    fn read() -> Self {
        Self(serde_json::from_str(include_str!("../fixtures/sat.json")).unwrap())
    }

    fn f32s(&self, name: &str) -> Vec<f32> {
        self.0[name].iter().map(|x| *x as f32).collect()
    }

    /// Within 2e-5 of the largest expected magnitude, or of what a sum of terms around 1 leaves.
    fn close(&self, name: &str, got: &[f32]) {
        let expected = &self.0[name];
        assert_eq!(expected.len(), got.len(), "{name}");
        let scale = expected.iter().fold(0.1_f64, |most, x| most.max(x.abs()));
        for (e, g) in expected.iter().zip(got) {
            assert!((e - f64::from(*g)).abs() <= 2e-5 * scale, "{name}: {g} for {e}");
        }
    }
}

#[test]
fn every_architecture_is_pytorchs_forward_and_backward() {
    let fixture = Fixture::read();
    for (name, backbone, attention) in KINDS {
        let sizes = sizes(backbone, attention);
        let layout = sizes.layout();
        let values: Vec<f32> =
            layout.entries().iter().flat_map(|entry| fixture.f32s(&format!("{name}.{}", entry.name))).collect();
        assert_eq!(values.len(), layout.len());
        let network = Network::new(sizes, &layout, &values);
        let (rows, fed) = (fixture.f32s(&format!("{name}.rows")), fixture.f32s(&format!("{name}.fed")));
        let (y, pass) = network.forward(&rows, &fed, SEQUENCES);
        fixture.close(&format!("{name}.y"), &y);
        let mut sums = vec![0.0; values.len()];
        network.backward(pass, &fixture.f32s(&format!("{name}.dy")), &mut sums);
        for entry in layout.entries() {
            fixture.close(&format!("{name}.d.{}", entry.name), &sums[layout.range(&entry.name)]);
        }
    }
}

#[test]
fn step_by_step_is_the_same_as_all_steps_at_once() {
    for (_, backbone, attention) in KINDS {
        let sizes = sizes(backbone, attention);
        let layout = sizes.layout();
        let network = Network::new(sizes, &layout, &layout.init(5, "test"));
        let numbers = |count: usize, key: f32| -> Vec<f32> { (0..count).map(|i| (i as f32 * key).sin()).collect() };
        let (rows, fed) = (numbers(40 * SEQUENCES * 3, 0.7), numbers(40 * SEQUENCES * 3, 1.3));
        let (expected, _) = network.forward(&rows, &fed, SEQUENCES);
        let stream = Stream::new(network);
        let (width, mut records): (usize, Vec<Vec<Vec<f32>>>) = (stream.record_width(), vec![Vec::new(); SEQUENCES]);
        for step in 0..40 {
            let part = |all: &[f32], width: usize| all[step * SEQUENCES * width..][..SEQUENCES * width].to_vec();
            let (row, fed, expected) = (part(&rows, 3), part(&fed, 3), part(&expected, 2));
            let kept = records.clone();
            let past = |row: usize| {
                let from = kept[row].len().saturating_sub(stream.history());
                kept[row][from..].iter().map(Vec::as_slice)
            };
            let got = stream.predict(&row, past);
            let close = got.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-5);
            assert!(close, "{backbone:?} {attention}, step {step}: {got:?} for {expected:?}");
            let mut new = vec![0.0; SEQUENCES * width];
            stream.remember(&row, &fed, past, &mut new);
            new.chunks_exact(width).zip(&mut records).for_each(|(record, all)| all.push(record.to_vec()));
        }
    }
}

/// Numbers around 0 that nothing else uses.
fn numbers(count: usize, key: f32) -> Vec<f32> {
    (0..count).map(|i| (i as f32 * key).sin()).collect()
}

/// PyTorch's network (above) less the measured errors of the step before, which the carried form adds outside of the network.
#[test]
fn without_carry_the_last_measured_error_is_an_input_and_no_more() {
    for (name, backbone, attention) in KINDS {
        let carried = sizes(backbone, attention);
        let plain = SatSizes { carry: false, ..carried };
        let layout = carried.layout();
        let values = layout.init(5, "test");
        let (rows, fed) = (numbers(12 * SEQUENCES * 3, 0.7), numbers(12 * SEQUENCES * 3, 1.3));
        let of = |sizes: SatSizes| Network::new(sizes, &layout, &values).forward(&rows, &fed, SEQUENCES).0;
        let (with, without) = (of(carried), of(plain));
        assert_eq!(with[..2 * SEQUENCES], without[..2 * SEQUENCES], "{name}: nothing was before the first step");
        for (i, (a, b)) in with.iter().zip(&without).enumerate().skip(2 * SEQUENCES) {
            let before = &fed[(i / 2 - SEQUENCES) * 3..][..3];
            let expected = before[i % 2] * before[2].max(0.0);
            assert!((a - b - expected).abs() < 1e-5, "{name}, number {i}: {a} less {b}, not {expected}");
        }
    }
    assert_eq!([true, false].map(|measured| SatSizes::default().known(measured)), [1.0, -1.0]);
    assert_eq!(SatSizes { carry: false, ..SatSizes::default() }.known(false), 1.0);
}

/// A closed loop's predictions, fed back all at once, give the same predictions: training learns from the loop that runs.
#[test]
fn a_closed_loop_is_the_pass_that_is_fed_its_predictions() {
    for (name, backbone, attention) in KINDS {
        let sizes = SatSizes { carry: false, ..sizes(backbone, attention) };
        let layout = sizes.layout();
        let network = Network::new(sizes, &layout, &layout.init(5, "test"));
        let rows = numbers(40 * SEQUENCES * 3, 0.7);
        let mut closed = ClosedLoop::new(network.clone(), SEQUENCES);
        let (mut out, mut fed) = (Vec::new(), Vec::new());
        for row in rows.chunks_exact(SEQUENCES * 3) {
            let y = closed.predict(row);
            let own: Vec<f32> = y.chunks_exact(2).flat_map(|y| [y[0], y[1], 1.0]).collect();
            closed.remember(row, &own);
            out.extend(y);
            fed.extend(own);
        }
        let (expected, _) = network.forward(&rows, &fed, SEQUENCES);
        let off = out.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off < 1e-5, "{name}: {off}");
        let (silent, _) = network.forward(&rows, &vec![0.0; fed.len()], SEQUENCES);
        assert!(out.iter().zip(&silent).any(|(a, b)| (a - b).abs() > 1e-3), "{name}: feedback matters");
    }
}
