//! Every block against PyTorch, forward and backward. `fixtures/make.py` writes what PyTorch computed (in float64).

use lifelike_checkpoint::Checkpoint;
use lifelike_dense::{AdamStep, Channel, PackedPerceptron, Sizes, Slices, pack, unpack};
use lifelike_nn::adam::{Adam, AdamConfig, Descent, Rule};
use lifelike_nn::conv_resnet::{self, ChannelNorm, Conv3, Down, ResBlock, Up, swapped};
use lifelike_nn::losses;
use lifelike_nn::parameters::{ParameterList, Parameters};
use lifelike_nn::rows::Layout;
use lifelike_nn::schedules::{Cyclical, WarmRestarts, cosine};
use lifelike_simd::InstructionSet;

use crate::fixture::Fixture;

fn blocks() -> Fixture {
    Fixture::read(include_str!("../fixtures/blocks.json"))
}

/// The fixture's parameters of one block, under `block`, and their gradients.
struct Block {
    fixture: Fixture,
    prefix: &'static str,
    parameters: Parameters,
    sums: Vec<f32>,
}

impl Block {
    fn new(prefix: &'static str, list: impl FnOnce(&mut ParameterList)) -> Self {
        let fixture = blocks();
        let mut all = ParameterList::default();
        list(&mut all);
        let fresh = all.finish();
        let mut parameters = fresh.clone();
        for entry in fresh.layout().entries() {
            let name = entry.name.replacen("block", prefix, 1);
            assert_eq!(fixture.shape(&name), entry.shape, "{name}");
            parameters.get_mut(&entry.name).copy_from_slice(&fixture.f32s(&name));
        }
        Self { sums: vec![0.0; parameters.len()], fixture, prefix, parameters }
    }

    fn name(&self, part: &str) -> String {
        format!("{}.{part}", self.prefix)
    }

    /// An array of the fixture, time first; `batch_first` says that it is not.
    fn rows(&self, part: &str, batch_first: bool) -> (Vec<f32>, usize) {
        let (rows, shape) = (self.fixture.f32s(&self.name(part)), self.fixture.shape(&self.name(part)));
        let shape = [shape[0], shape[1], shape[2]];
        if batch_first { (swapped(&rows, shape), shape[1]) } else { (rows, shape[0]) }
    }

    fn close(&self, part: &str, got: &[f32], batch_first: bool) {
        let shape = self.fixture.shape(&self.name(part));
        let got = if batch_first { swapped(got, [shape[1], shape[0], shape[2]]) } else { got.to_vec() };
        self.fixture.close(&self.name(part), &got);
    }

    fn gradients_close(&self) {
        for entry in self.parameters.layout().entries() {
            let name = entry.name.replacen("block", &format!("{}.d", self.prefix), 1);
            self.fixture.close(&name, &self.sums[self.parameters.range(&entry.name)]);
        }
    }
}

#[test]
fn layer_norm_over_channels() {
    let mut b = Block::new("norm", |list| conv_resnet::add_norm(list, "block", 6));
    let norm = ChannelNorm::new("block", &b.parameters);
    let (x, _) = b.rows("x", false);
    b.close("y", &norm.forward(&x), false);
    let by_x = norm.backward(&x, &b.rows("dy", false).0, &mut b.sums);
    b.close("d.x", &by_x, false);
    b.gradients_close();
}

#[test]
fn convolution_with_kernel_3() {
    let mut b = Block::new("conv3", |list| conv_resnet::add_conv3(list, "block", [4, 5], 0, "test"));
    let conv = Conv3::new("block", [4, 5], &b.parameters);
    let (x, steps) = b.rows("x", false);
    b.close("y", &conv.forward(&x, steps), false);
    let by_x = conv.backward(&x, &b.rows("dy", false).0, steps, &mut b.sums);
    b.close("d.x", &by_x, false);
    b.gradients_close();
}

#[test]
fn strided_convolution_and_its_transpose() {
    let mut b = Block::new("down", |list| conv_resnet::add_down(list, "block", [4, 5], 0, "test"));
    let down = Down::new("block", [4, 5], &b.parameters);
    let (x, steps) = b.rows("x", true);
    b.close("y", &down.forward(&x, steps), true);
    let by_x = down.backward(&x, &b.rows("dy", true).0, steps, &mut b.sums);
    b.close("d.x", &by_x, true);
    b.gradients_close();

    let mut b = Block::new("up", |list| conv_resnet::add_up(list, "block", [4, 5], 0, "test"));
    let up = Up::new("block", [4, 5], &b.parameters);
    let (x, steps) = b.rows("x", true);
    b.close("y", &up.forward(&x, steps), true);
    let by_x = up.backward(&x, &b.rows("dy", true).0, steps, &mut b.sums);
    b.close("d.x", &by_x, true);
    b.gradients_close();
}

#[test]
fn residual_block() {
    let mut b = Block::new("block", |list| conv_resnet::add_block(list, "block", 6, 0, "test"));
    let block = ResBlock::new("block", 6, &b.parameters);
    let (x, steps) = b.rows("x", false);
    let (y, pass) = block.forward(x, steps);
    b.close("y", &y, false);
    let by_x = block.backward(&pass, b.rows("dy", false).0, steps, &mut b.sums);
    b.close("d.x", &by_x, false);
    b.gradients_close();
}

#[test]
fn kl_divergence() {
    let f = blocks();
    let [mean, log_variance, dy] = ["kl.mean", "kl.log_variance", "kl.dy"].map(|name| f.f32s(name));
    let (mut by_mean, mut by_log_variance) = (vec![0.0; mean.len()], vec![0.0; mean.len()]);
    let values: Vec<f32> = (0..dy.len())
        .map(|row| {
            let own = row * 5..(row + 1) * 5;
            let by = [&mut by_mean[own.clone()], &mut by_log_variance[own.clone()]];
            losses::kl_from_standard_normal([&mean[own.clone()], &log_variance[own]], dy[row], by)
        })
        .collect();
    f.close("kl.y", &values);
    f.close("kl.d.mean", &by_mean);
    f.close("kl.d.log_variance", &by_log_variance);
}

#[test]
fn rotation_distance() {
    let f = blocks();
    let six = |name: &str| -> Vec<[f32; 6]> { f.f32s(name).as_chunks().0.to_vec() };
    let (a, b, dy) = (six("rotation.a"), six("rotation.b"), f.f32s("rotation.dy"));
    let mut values = Vec::new();
    let (mut by_a, mut by_b) = (Vec::new(), Vec::new());
    for ((a, b), dy) in a.iter().zip(&b).zip(dy) {
        let (value, gradient) = losses::rotation_distance_squared(*a, *b);
        values.push(value);
        by_b.extend(gradient.map(|x| x * dy));
        // The distance is the same both ways.
        by_a.extend(losses::rotation_distance_squared(*b, *a).1.map(|x| x * dy));
    }
    f.close("rotation.y", &values);
    f.close("rotation.d.a", &by_a);
    f.close("rotation.d.b", &by_b);
}

fn check_optimizer(config: AdamConfig, name: &str) {
    let f = blocks();
    // The matrix stands where those of a transformer do.
    let layout = Layout::of_shapes(vec![("blocks.p".into(), vec![3, 4])]);
    let (mut values, mut adam) = (f.f32s("optimizer.start"), Adam::new(config, layout.len()));
    let mut path = Vec::new();
    for (step, gradient) in f.f32s("optimizer.gradients").chunks_exact(layout.len()).enumerate() {
        if step == 7 {
            // Saved and loaded in the middle: nothing may change.
            let mut c = Checkpoint::new();
            adam.save_into(&layout, &mut c, "optimizer").unwrap();
            let loaded = Adam::load_from(config, &layout, &c, "optimizer").unwrap();
            assert_eq!(loaded, adam);
            adam = loaded;
        }
        let descent = Descent { gradient, max_norm: f64::INFINITY, rate: 0.003 };
        assert!(adam.step(&layout, &mut values, descent).taken);
        path.extend_from_slice(&values);
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

/// A step with a bound on the norm is a step with the gradient that PyTorch's `clip_grad_norm_` leaves.
#[test]
fn clipping_by_the_norm_of_all_gradients() {
    let f = blocks();
    let layout = Layout::of_shapes(vec![("p".into(), vec![3, 4])]);
    let gradient = &f.f32s("optimizer.gradients")[..12];
    let stepped = |gradient: &[f32], max_norm: f64| {
        let (mut values, mut adam) = (f.f32s("optimizer.start"), Adam::new(AdamConfig::adam(), 12));
        let stepped = adam.step(&layout, &mut values, Descent { gradient, max_norm, rate: 0.003 });
        let [first, _] = adam.state().1;
        (stepped.norm, first.to_vec())
    };
    let (norm, first) = stepped(gradient, 1.0);
    f.close("clip.norm", &[norm as f32]);
    // The first moment is a tenth of the gradient.
    f.close("clip.gradient", &first.iter().map(|x| x * 10.0).collect::<Vec<_>>());
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
