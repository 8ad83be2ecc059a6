//! Every block against PyTorch, forward and backward. `fixtures/make.py` writes what PyTorch computed (in float64).

#![allow(clippy::unwrap_used, clippy::expect_used)]

use burn::module::{Module, Param};
use burn::tensor::Tensor;
use lifelike_checkpoint::Checkpoint;
use lifelike_dense::{AdamStep, Channel, PackedPerceptron, Sizes, Slices, pack, unpack};
use lifelike_nn::adam::{Adam, AdamConfig, Rule};
use lifelike_nn::conv_resnet::{ChannelNorm, Conv3, Down, ResBlock, Up};
use lifelike_nn::gradients::Gradients;
use lifelike_nn::mlp::MlpConfig;
use lifelike_nn::schedules::{Cyclical, WarmRestarts, cosine};
use lifelike_nn::{device, init, losses};
use lifelike_simd::InstructionSet;

mod fixture;

use fixture::Fixture;

fn blocks() -> Fixture {
    Fixture::read(include_str!("fixtures/blocks.json"))
}

#[test]
fn mlp_with_elu() {
    let config = MlpConfig::new(5, &[8, 7], 3);
    blocks().check("mlp", config.init(0, "test", &device::training()), |m, x: Tensor<2>| m.forward(x));
}

#[test]
fn layer_norm_over_channels() {
    let module = ChannelNorm::new(6, &device::training());
    blocks().check("norm", module, |m, x: Tensor<3>| m.forward(x));
}

#[test]
fn convolutions() {
    let (f, d) = (blocks(), device::training());
    f.check("conv3", Conv3::new(4, 5, 0, "test", &d), |m, x: Tensor<3>| m.forward(x));
    f.check("down", Down::new(4, 5, 0, "test", &d), |m, x: Tensor<3>| m.forward(x));
    f.check("up", Up::new(4, 5, 0, "test", &d), |m, x: Tensor<3>| m.forward(x));
}

#[test]
fn residual_block() {
    let module = ResBlock::new(6, 0, "test", &device::training());
    blocks().check("block", module, |m, x: Tensor<3>| m.forward(x));
}

fn check_two_inputs(prefix: &str, names: [&str; 2], loss: impl Fn(Tensor<2>, Tensor<2>) -> Tensor<1>) {
    let f = blocks();
    let [a, b] = names.map(|n| f.tensor::<2>(&format!("{prefix}.{n}")).require_grad());
    let y = loss(a.clone(), b.clone());
    f.tensor_close(&format!("{prefix}.y"), &y);
    let mut recorded = (y * f.tensor::<1>(&format!("{prefix}.dy"))).sum().backward();
    for (name, x) in names.iter().zip([a, b]) {
        f.tensor_close(&format!("{prefix}.d.{name}"), &x.grad_remove(&mut recorded).unwrap());
    }
}

#[test]
fn kl_divergence() {
    check_two_inputs("kl", ["mean", "log_variance"], losses::kl_from_standard_normal);
}

#[test]
fn rotation_distance() {
    check_two_inputs("rotation", ["a", "b"], losses::rotation_distance_squared);
}

#[derive(Module, Debug)]
struct One {
    p: Param<Tensor<2>>,
}

impl One {
    fn at_start(f: &Fixture) -> Self {
        Self { p: init::parameter(f.f32s("optimizer.start"), [3, 4], &device::training()) }
    }

    fn gradients(&self, f: &Fixture, step: usize) -> Gradients {
        let g = f.tensor::<3>("optimizer.gradients").narrow(0, step, 1).squeeze_dim::<2>(0);
        Gradients::of(self, (self.p.val() * g).sum().backward())
    }
}

/// With its matrix where those of a transformer stand.
#[derive(Module, Debug)]
struct Stack {
    blocks: One,
}

impl Stack {
    fn at_start(f: &Fixture) -> Self {
        Self { blocks: One::at_start(f) }
    }

    fn gradients(&self, f: &Fixture, step: usize) -> Gradients {
        let mut gradients = Gradients::default();
        gradients.insert("blocks.p".into(), self.blocks.gradients(f, step).get("p").unwrap().clone());
        gradients
    }
}

fn check_optimizer(config: AdamConfig, name: &str) {
    let f = blocks();
    let mut model = Stack::at_start(&f);
    let mut adam = Adam::new(config);
    let mut path = Vec::new();
    for step in 0..10 {
        if step == 7 {
            // Saved and loaded in the middle: nothing may change.
            let mut c = Checkpoint::new();
            adam.save_into(&mut c, "optimizer").unwrap();
            adam = Adam::load_from(config, &c, "optimizer", &model).unwrap();
        }
        let gradients = model.gradients(&f, step);
        model = adam.step(model, gradients, 0.003);
        path.extend(model.blocks.p.val().try_to_vec_as::<f32>().unwrap());
    }
    f.close(&format!("{name}.path"), &path);
    // Steps are 0.003 long while parameters are about 1: compare what was walked, not only where it ended.
    let start = f.f32s("optimizer.start");
    for (i, (expected, got)) in f.data(&format!("{name}.path")).iter().zip(&path).enumerate() {
        let walked = expected - f64::from(start[i % 12]);
        let error = expected - f64::from(*got);
        assert!(error.abs() < 1e-6, "{name} entry {i}: walked {walked:e}, off by {error:e}");
    }
}

#[test]
fn adam_ten_steps() {
    check_optimizer(AdamConfig::adam(), "adam");
}

#[test]
fn radam_ten_steps_through_the_rectification_threshold() {
    check_optimizer(AdamConfig::radam(), "radam");
}

#[test]
fn muon_ten_steps() {
    check_optimizer(AdamConfig { rule: Rule::Muon, ..AdamConfig::adam() }, "muon");
}

#[test]
fn clipping_by_the_norm_of_all_gradients() {
    let f = blocks();
    let model = One::at_start(&f);
    let mut gradients = model.gradients(&f, 0);
    let norm = gradients.clip_norm(1.0).unwrap();
    f.close("clip.norm", &[norm as f32]);
    f.tensor_close("clip.gradient", gradients.get("p").unwrap());
    assert!((gradients.norm().unwrap() - 1.0).abs() < 1e-5);
}

fn check_schedule(name: &str, at: impl Fn(u64) -> f64, tolerance: f64) {
    let f = blocks();
    for (i, expected) in f.data(name).iter().enumerate() {
        let got = at(i as u64);
        assert!((expected - got).abs() <= tolerance, "{name} at {i}: expected {expected}, got {got}");
    }
}

#[test]
fn schedules() {
    let short = WarmRestarts { first: 3, factor: 2, floor: 0.0 };
    check_schedule("warm_restarts", |i| short.at(i), 1e-8);
    let thesis = WarmRestarts { first: 1000, factor: 5, floor: 0.0 };
    check_schedule("warm_restarts_thesis", |i| thesis.at(997 * i), 1e-8);
    check_schedule("cosine", |i| cosine(i, 20, 0.1), 1e-8);
    let cyclical = Cyclical { total: 700, cycles: 7, ratio: 0.5 };
    check_schedule("cyclical", |i| cyclical.at(i), 1e-8);
    assert_eq!(cyclical.at(10_000), 1.0);
}

#[test]
fn fused_kernels_of_a_perceptron_forward_and_backward() {
    let f = blocks();
    let sizes = Sizes::new(&[5, 8, 7, 3]);
    let named: Vec<String> = (0..3).flat_map(|i| [format!("layers.{i}.weight"), format!("layers.{i}.bias")]).collect();
    let gather = |prefix: &str| named.iter().flat_map(|name| f.f32s(&format!("{prefix}.{name}"))).collect::<Vec<_>>();
    let (x, dy, parameters) = (f.f32s("mlp.x"), f.f32s("mlp.dy"), gather("mlp"));
    for set in InstructionSet::available() {
        let network = PackedPerceptron::new(set, sizes.clone(), &parameters);
        let mut panel = vec![Channel::ZERO; network.channels()];
        pack(x.chunks_exact(5), network.inputs(&mut panel));
        network.forward(&mut panel);
        let mut y = vec![0.0; dy.len()];
        unpack(network.outputs(&panel), &mut y);
        f.close("mlp.y", &y);
        pack(dy.chunks_exact(3), network.by_outputs(&mut panel));
        network.backward(&mut panel, true);
        let mut by_x = vec![0.0; x.len()];
        unpack(network.by_inputs(&panel), &mut by_x);
        f.close("mlp.d.x", &by_x);
        let mut gradient = vec![f32::NAN; sizes.parameters()];
        network.gradient(&panel, network.channels(), 0, &mut gradient);
        let mut rest = &gradient[..];
        for name in &named {
            let name = format!("mlp.d.{name}");
            let (own, after) = rest.split_at(f.data(&name).len());
            f.close(&name, own);
            rest = after;
        }
        assert!(rest.is_empty());
    }
}

#[test]
fn fused_adam() {
    let f = blocks();
    let mut values = f.f32s("optimizer.start");
    let n = values.len();
    let (mut first, mut second) = (vec![0.0; n], vec![0.0; n]);
    let mut path = Vec::new();
    for (t, gradient) in f.f32s("optimizer.gradients").chunks_exact(n).enumerate() {
        let step = AdamStep { beta_1: 0.9, beta_2: 0.999, epsilon: 1e-8, step: t as u64 + 1, rate: 0.003, scale: 1.0 };
        let slices = Slices { values: &mut values, gradient, first: &mut first, second: &mut second };
        step.take(InstructionSet::chosen(), slices);
        path.extend_from_slice(&values);
    }
    f.close("adam.path", &path);
}
