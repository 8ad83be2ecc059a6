//! Splines and transformer blocks against PyTorch and scipy. `fixtures/make_transformer.py` writes what they computed (in
//! float64).

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod fixture;

use burn::tensor::{Device, Tensor, TensorData};
use fixture::Fixture;
use lifelike_nn::gradients::Gradients;
use lifelike_nn::spline::{BSpline, CubicBezier, Joints, Spline};
use lifelike_nn::transformer::backprop::Weights;
use lifelike_nn::transformer::{
    Attention, AutoencoderConfig, Block, FeedForward, LatentTokens, RmsNorm, Sampling, SplineAutoencoder, alibi,
};
use lifelike_nn::{device, parameters};

fn transformer() -> Fixture {
    Fixture::read(include_str!("fixtures/transformer.json"))
}

fn bias(heads: usize, tokens: usize) -> Tensor<3> {
    let positions: Vec<f64> = (0..tokens).map(|i| i as f64).collect();
    alibi::bias_tensor(heads, &positions, &device::training())
}

fn each_kind() -> [(&'static str, LatentTokens); 3] {
    [
        ("spline", LatentTokens::Spline(Spline::default())),
        ("alibi", LatentTokens::Alibi),
        ("alibi_cat", LatentTokens::AlibiCat),
    ]
}

fn small(tokens: LatentTokens, device: &Device) -> SplineAutoencoder {
    let layers = if matches!(tokens, LatentTokens::Spline(_)) { 2 } else { 1 };
    AutoencoderConfig::new(3, 3, layers, 2, 8).with_tokens(tokens).init(0, "test", device).unwrap()
}

#[test]
fn basis_functions_and_their_derivatives_are_scipys() {
    let f = transformer();
    for (name, degree) in [("clamped", 3), ("unclamped", 2), ("uneven", 4), ("linear", 1), ("steps", 0), ("bezier", 3)]
    {
        let curve = BSpline::new(degree, f.data(&format!("spline.{name}.knots")).to_vec()).unwrap();
        let t = f.data(&format!("spline.{name}.t"));
        for derivative in 0..=degree.min(3) {
            let expected = f.data(&format!("spline.{name}.weights_{derivative}"));
            let got: Vec<f64> = t.iter().flat_map(|t| curve.weights(*t, derivative).unwrap()).collect();
            assert_eq!(expected.len(), got.len());
            let scale = expected.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
            for (i, (e, g)) in expected.iter().zip(&got).enumerate() {
                // The fixture has nine digits.
                assert!((e - g).abs() <= 1e-8 * scale, "{name}, derivative {derivative}, entry {i}: {e} {g}");
            }
        }
    }
}

#[test]
fn curves_are_evaluated_as_by_algorithm_3_and_scipy() {
    let f = transformer();
    let evaluate = |name: &str, spline: Spline, samples: usize| {
        let x = f.tensor::<3>(&format!("evaluate.{name}.x")).require_grad();
        let y = spline.evaluate(x.clone(), samples).unwrap();
        f.tensor_close(&format!("evaluate.{name}.y"), &y);
        let mut tape = (y * f.tensor::<3>(&format!("evaluate.{name}.dy"))).sum().backward();
        f.tensor_close(&format!("evaluate.{name}.d.x"), &x.grad_remove(&mut tape).unwrap());
    };
    evaluate("bezier", Spline::default(), 11);
    evaluate("segments", Spline::Bezier(CubicBezier::new(2, Joints::Separate).unwrap()), 17);
    evaluate("bspline", Spline::BSpline(BSpline::clamped(3, 8).unwrap()), 13);
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
fn normalization() {
    for name in ["rms", "rms_small"] {
        transformer().check(name, RmsNorm::new(8, &device::training()), |m, x: Tensor<3>| m.forward(x));
    }
}

#[test]
fn attention_with_linear_biases() {
    for heads in [2, 3] {
        let module = Attention::new(4 * heads, heads, 0, "test", &device::training());
        transformer().check(&format!("attention.{heads}"), module, |m, x: Tensor<3>| m.forward(x, bias(heads, 7)));
    }
}

#[test]
fn feed_forward_with_gelu() {
    let module = FeedForward::new(6, 2, 0, "test", &device::training());
    transformer().check("feed_forward", module, |m, x: Tensor<3>| m.forward(x));
}

#[test]
fn pre_norm_block() {
    let module = Block::new(8, 2, 1, 0, "test", &device::training());
    transformer().check("block", module, |m, x: Tensor<3>| m.forward(x, bias(2, 6)));
}

#[test]
fn whole_networks() {
    for (kind, tokens) in each_kind() {
        let module = small(tokens, &device::training());
        transformer().check(&format!("network.{kind}"), module, |m, x: Tensor<3>| m.forward(x).unwrap());
    }
}

#[test]
fn more_samples_than_were_encoded_stand_at_fractions() {
    let f = transformer();
    let module = f.load("network.dense", small(LatentTokens::Alibi, &device::training()));
    let points = module.encode(f.tensor("network.dense.x"));
    f.tensor_close("network.dense.y", &module.decode(points, &Sampling::even(5, 10)).unwrap());
}

#[test]
fn whole_networks_by_hand() {
    let f = transformer();
    for (kind, tokens) in each_kind() {
        let name = |part: &str| format!("network.{kind}.{part}");
        let module = f.load(&format!("network.{kind}"), small(tokens, &device::training()));
        let weights = Weights::of(&module).unwrap();
        let (output, pass) = weights.forward(f.f32s(&name("x")), 5).unwrap();
        f.close(&name("y"), &output.sequence);
        let gradients = weights.named(&weights.backward(pass, &f.f32s(&name("dy")), None).unwrap());
        for (parameter, _) in parameters(&module) {
            f.tensor_close(&name(&format!("d.{parameter}")), gradients.get(&parameter).unwrap());
        }
    }
}

/// Sizes that fill no panel, no tile and no thread evenly, and slopes by the control points too.
#[test]
fn gradients_by_hand_are_those_of_automatic_differentiation() {
    for (heads, width, tokens, batch, factor) in [(4, 64, 37, 21, 1), (3, 24, 70, 2, 2), (1, 20, 1, 3, 1)] {
        for (kind, latent_tokens) in each_kind().into_iter().chain([("wide", LatentTokens::AlibiCatWide)]) {
            let config = AutoencoderConfig {
                factor,
                ..AutoencoderConfig::new(5, 6, 2, heads, width).with_tokens(latent_tokens.clone())
            };
            let network = config.init(1, "test", &device::training()).unwrap();
            let shape = [batch, tokens, 5];
            let x = wave::<3>(shape, 0.37);
            let points = network.encode(x.clone());
            let y = network.decode(points.clone(), &Sampling::each(tokens)).unwrap();
            // Not around 0: sequences are alike before training, and their gradients would cancel to rounding errors.
            let (dy, dp) = (wave::<3>(shape, 0.11) + 1.0, wave::<3>(points.dims(), 0.23));
            let tape = ((y.clone() * dy.clone()).sum() + (points.clone() * dp.clone()).sum()).backward();
            let expected = Gradients::of(&network, tape);

            let numbers = |x: Tensor<3>| x.try_into_vec_as::<f32>().unwrap();
            let weights = Weights::of(&network).unwrap();
            let (output, pass) = weights.forward(numbers(x), tokens).unwrap();
            close(&output.sequence, &numbers(y), "sequence");
            close(&output.control_points, &numbers(points), "control points");
            let got = weights.named(&weights.backward(pass, &numbers(dy), Some(&numbers(dp))).unwrap());
            assert_eq!(got.names().collect::<Vec<_>>(), expected.names().collect::<Vec<_>>());
            for name in expected.names() {
                let [a, b] = [&got, &expected].map(|g| g.get(name).unwrap().try_to_vec_as::<f32>().unwrap());
                close(&a, &b, &format!("{kind}, {heads} heads, {tokens} tokens: {name}"));
            }
        }
    }
}

#[test]
fn passes_refuse_what_does_not_fit() {
    let weights = Weights::of(&small(LatentTokens::Alibi, &device::training())).unwrap();
    for (x, tokens) in [(vec![0.0; 16], 5), (vec![], 5), (vec![0.0; 15], 0)] {
        assert!(weights.forward(x, tokens).unwrap_err().to_string().contains("sequences"));
    }
    let pass = || weights.forward(vec![0.0; 30], 5).unwrap().1;
    let wrong = weights.backward(pass(), &[0.0; 15], None).unwrap_err().to_string();
    assert!(wrong.contains("30 numbers, got 15"), "{wrong}");
    assert!(weights.backward(pass(), &[0.0; 30], Some(&[0.0; 5])).is_err());
}

fn wave<const D: usize>(shape: [usize; D], pace: f32) -> Tensor<D> {
    let values: Vec<f32> = (0..shape.iter().product()).map(|i| (i as f32 * pace).sin()).collect();
    Tensor::from_data(TensorData::new(values, shape), &device::training())
}

/// As vectors they differ by no more than 1e-5: both are float32, and the largest difference measured was 1.1e-6.
fn close(got: &[f32], expected: &[f32], name: &str) {
    assert_eq!(got.len(), expected.len(), "{name}");
    let norm = |x: &mut dyn Iterator<Item = f32>| x.map(|x| f64::from(x).powi(2)).sum::<f64>().sqrt();
    let size = norm(&mut expected.iter().copied());
    let error = norm(&mut got.iter().zip(expected).map(|(a, b)| a - b));
    assert!(error <= 1e-5 * size, "{name}: off by {error:e} at {size:e}");
}
