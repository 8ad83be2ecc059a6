//! Splines and transformer blocks against PyTorch and scipy. `fixtures/make_transformer.py` writes what they computed (in
//! float64).

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod fixture;

use burn::tensor::{Device, Tensor};
use fixture::Fixture;
use lifelike_nn::device;
use lifelike_nn::spline::{BSpline, CubicBezier, Joints, Spline};
use lifelike_nn::transformer::{
    Attention, AutoencoderConfig, Block, FeedForward, LatentTokens, RmsNorm, Sampling, SplineAutoencoder, alibi,
};

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
    transformer().check("rms", RmsNorm::new(8, &device::training()), |m, x: Tensor<3>| m.forward(x));
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
