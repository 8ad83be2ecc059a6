//! Splines and transformer networks against PyTorch and scipy. `fixtures/make_transformer.py` writes what they computed (in
//! float64).

use crate::fixture::Fixture;
use lifelike_nn::spline::{BSpline, CubicBezier, uniform};
use lifelike_nn::transformer::{AutoencoderConfig, LatentTokens, Sampling, SplineAutoencoder, alibi};

fn transformer() -> Fixture {
    Fixture::read(include_str!("../fixtures/transformer.json"))
}

fn each_kind() -> [(&'static str, LatentTokens); 3] {
    [
        ("spline", LatentTokens::Spline(CubicBezier)),
        ("alibi", LatentTokens::Alibi),
        ("alibi_cat", LatentTokens::AlibiCat),
    ]
}

fn small(tokens: LatentTokens) -> SplineAutoencoder {
    let layers = if matches!(tokens, LatentTokens::Spline(_)) { 2 } else { 1 };
    AutoencoderConfig::new(3, 3, layers, 2, 8).with_tokens(tokens).init(0, "test").unwrap()
}

/// A small network with the fixture's parameters.
fn loaded(f: &Fixture, prefix: &str, tokens: LatentTokens) -> SplineAutoencoder {
    let network = small(tokens);
    let parameters = f.load(prefix, network.parameters());
    network.with_parameters(parameters)
}

/// The fixture's curve has degree 2 and nine digits.
#[test]
fn basis_functions_and_their_derivatives_are_scipys() {
    let f = transformer();
    let curve = BSpline::new(2, 6).unwrap();
    let t = f.data("spline.unclamped.t");
    for derivative in 0..=2 {
        let expected = f.data(&format!("spline.unclamped.weights_{derivative}"));
        let got: Vec<f64> = t.iter().flat_map(|t| curve.weights(*t, derivative).unwrap()).collect();
        assert_eq!(expected.len(), got.len());
        let scale = expected.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
        for (i, (e, g)) in expected.iter().zip(&got).enumerate() {
            assert!((e - g).abs() <= 1e-8 * scale, "derivative {derivative}, entry {i}: {e} {g}");
        }
    }
}

#[test]
fn curves_are_evaluated_as_by_algorithm_3() {
    let f = transformer();
    let array = |part: &str| f.f32s(&format!("evaluate.bezier.{part}"));
    f.close("evaluate.bezier.y", &CubicBezier.evaluate(&array("x"), 3, &uniform(11)).unwrap());
    let by_x = CubicBezier.by_control_points(&array("dy"), 3, &uniform(11)).unwrap();
    f.close("evaluate.bezier.d.x", &by_x);
}

#[test]
fn slopes_are_those_of_the_published_code() {
    let f = transformer();
    for heads in [1, 2, 3, 4, 6, 8, 12, 16, 20] {
        let got: Vec<f32> = alibi::slopes(heads).into_iter().map(|s| s as f32).collect();
        f.close(&format!("slopes.{heads}"), &got);
    }
}

#[test]
fn whole_networks_forward_and_backward() {
    let f = transformer();
    for (kind, tokens) in each_kind() {
        let prefix = format!("network.{kind}");
        let array = |part: &str| f.f32s(&format!("{prefix}.{part}"));
        let network = loaded(&f, &prefix, tokens);
        f.close(&format!("{prefix}.y"), &network.forward(&array("x"), 5).unwrap());
        let weights = network.weights();
        let (output, pass) = weights.forward(array("x"), 5).unwrap();
        f.close(&format!("{prefix}.y"), &output.sequence);
        let sums = weights.backward(pass, &array("dy"), None).unwrap();
        f.gradients_close(&prefix, network.parameters(), &sums);
    }
}

#[test]
fn more_samples_than_were_encoded_stand_at_fractions() {
    let f = transformer();
    let weights = loaded(&f, "network.dense", LatentTokens::Alibi).weights();
    let points = weights.encode(&f.f32s("network.dense.x"), 5).unwrap();
    f.close("network.dense.y", &weights.decode(&points, &Sampling::even(5, 10)).unwrap());
}

/// Sizes that fill no panel, no tile and no thread evenly, and slopes by the control points too.
#[test]
fn gradients_are_those_of_finite_differences_along_random_directions() {
    for (heads, width, tokens, batch, factor) in [(4, 64, 37, 5, 1), (3, 24, 70, 2, 2), (1, 20, 1, 3, 1)] {
        for (kind, latent_tokens) in each_kind().into_iter().chain([("wide", LatentTokens::AlibiCatWide)]) {
            let config = AutoencoderConfig {
                factor,
                ..AutoencoderConfig::new(5, 6, 2, heads, width).with_tokens(latent_tokens.clone())
            };
            let network = config.init(1, "test").unwrap();
            let points = latent_tokens.control_points();
            let x = wave(batch * tokens * 5, 0.37);
            // Not around 0: sequences are alike before training, and their gradients would cancel to rounding errors.
            let dy: Vec<f32> = wave(x.len(), 0.11).into_iter().map(|x| x + 1.0).collect();
            let dp = wave(batch * points * 6, 0.23);
            let weights = network.weights();
            let (output, pass) = weights.forward(x.clone(), tokens).unwrap();
            assert_eq!(weights.encode(&x, tokens).unwrap(), output.control_points);
            let sums = weights.backward(pass, &dy, Some(&dp)).unwrap();
            let loss = |network: &SplineAutoencoder| {
                let (output, _) = network.weights().forward(x.clone(), tokens).unwrap();
                dot(&output.sequence, &dy) + dot(&output.control_points, &dp)
            };
            for entry in network.parameters().layout().entries() {
                let range = network.parameters().range(&entry.name);
                // Along the gradient itself nothing cancels.
                let size = dot(&sums[range.clone()], &sums[range.clone()]).sqrt();
                let moved = |by: f64| {
                    let mut network = network.clone();
                    let values = network.parameters_mut().get_mut(&entry.name).iter_mut();
                    values
                        .zip(&sums[range.clone()])
                        .for_each(|(x, along)| *x += (by * f64::from(*along) / size) as f32);
                    loss(&network)
                };
                let slope = (moved(0.02) - moved(-0.02)) / 0.04;
                let name = format!("{kind}, {heads} heads, {tokens} tokens: {}", entry.name);
                assert!((slope - size).abs() < 0.02 * size, "{name}: {slope} along a gradient of {size}");
            }
        }
    }
}

fn dot(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a * b)).sum()
}

#[test]
fn passes_refuse_what_does_not_fit() {
    let weights = small(LatentTokens::Alibi).weights();
    for (x, tokens) in [(vec![0.0; 16], 5), (vec![], 5), (vec![0.0; 15], 0)] {
        assert!(weights.forward(x, tokens).unwrap_err().to_string().contains("sequences"));
    }
    let pass = || weights.forward(vec![0.0; 30], 5).unwrap().1;
    let wrong = weights.backward(pass(), &[0.0; 15], None).unwrap_err().to_string();
    assert!(wrong.contains("30 numbers, got 15"), "{wrong}");
    assert!(weights.backward(pass(), &[0.0; 30], Some(&[0.0; 5])).is_err());
    assert!(weights.decode(&[0.0; 4], &Sampling::each(5)).unwrap_err().to_string().contains("control points"));
}

fn wave(count: usize, pace: f32) -> Vec<f32> {
    (0..count).map(|i| (i as f32 * pace).sin()).collect()
}
