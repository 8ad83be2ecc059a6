//! Passes of a perceptron on one thread, beside the machine's peak: `cargo run --release -p lifelike-dense --example throughput`.
//!
//! Numbers are Gflop/s of one core; every layer's multiplications and additions count, nothing else does.

use std::hint::black_box;
use std::time::Instant;

use lifelike_dense::{Channel, PackedPerceptron, Perceptron, ROWS, Sizes, pack};
use lifelike_simd::{InstructionSet, Simd, Task, prelude::*};

/// Sums that do not wait for one another: twelve multiply-adds are under way at once.
struct Peak(usize);

impl Task for Peak {
    type Output = f32;
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> f32 {
        let x = S::f32s::splat(simd, black_box(1.0 - 1e-7));
        let mut sums = [S::f32s::splat(simd, 1.0); 12];
        for _ in 0..self.0 {
            sums.iter_mut().for_each(|sum| *sum = sum.mul_add_precise(x, x));
        }
        sums.iter().fold(0.0, |all, sum| all + sum.as_slice()[0])
    }
}

/// This thread's time so far (s): others use the machine too.
fn time() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split(' ').next()?.parse::<f64>().ok().map(|ns| 1e-9 * ns)
}

/// Mean time of a run (s), of runs that take a third of a second together.
fn seconds(mut work: impl FnMut()) -> f64 {
    work();
    let (began, first) = (Instant::now(), time());
    let mut runs = 0.0;
    while began.elapsed().as_secs_f64() < 0.3 {
        work();
        runs += 1.0;
    }
    let used = time().zip(first).map_or(began.elapsed().as_secs_f64(), |(now, first)| now - first);
    used / runs
}

fn main() {
    let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(1).build() else { return };
    pool.install(measure);
}

fn measure() {
    let sizes = Sizes::new(&[160, 512, 256, 128, 23]);
    let flop = |layers: usize, rows: usize| {
        let all = sizes.layers().iter().skip(layers);
        2e-9 * rows as f64 * all.map(|layer| (layer.inputs * layer.outputs) as f64).sum::<f64>()
    };
    let parameters: Vec<f32> = (0..sizes.parameters()).map(|i| ((i * 37) % 101) as f32 * 1e-3 - 0.05).collect();
    println!(
        "{:>9} {:>5} {:>7} {:>8} {:>9} {:>10} {:>8} {:>6}",
        "set", "rows", "peak", "forward", "backward", "by weight", "all", "act"
    );
    for set in InstructionSet::available() {
        let steps = if set == InstructionSet::Portable { 1000 } else { 1_000_000 };
        let width = match set {
            InstructionSet::Avx512 => 16,
            InstructionSet::Avx2 => 8,
            _ => 4,
        };
        let peak = 2e-9 * 12.0 * (width * steps) as f64
            / seconds(|| {
                black_box(set.run(Peak(steps)));
            });
        for count in [768, 1024] {
            let rows = if set == InstructionSet::Portable { ROWS } else { count };
            let mut network = PackedPerceptron::new(set, sizes.clone(), &parameters);
            let inputs: Vec<f32> = (0..rows * 160).map(|i| ((i * 7) % 103) as f32 * 0.02 - 1.0).collect();
            let channels = network.channels();
            let mut panels = vec![Channel::ZERO; rows.div_ceil(ROWS) * channels];
            let fill = |network: &PackedPerceptron, panels: &mut [Channel]| {
                for (panel, rows) in panels.chunks_exact_mut(channels).zip(inputs.chunks(ROWS * 160)) {
                    pack(rows.chunks_exact(160), network.inputs(panel));
                    pack(rows.chunks_exact(160).map(|row| &row[..23]), network.by_outputs(panel));
                }
            };
            fill(&network, &mut panels);
            let forward = seconds(|| panels.chunks_exact_mut(channels).for_each(|panel| network.forward(panel)));
            let backward =
                seconds(|| panels.chunks_exact_mut(channels).for_each(|panel| network.backward(panel, false)));
            let mut gradient = vec![0.0; sizes.parameters()];
            let by_weight = seconds(|| network.gradient(&panels, channels, 0, &mut gradient));
            let all = seconds(|| {
                network.set(&parameters);
                fill(&network, &mut panels);
                panels.chunks_exact_mut(channels).for_each(|panel| {
                    network.forward(panel);
                    network.backward(panel, false);
                });
                network.gradient(&panels, channels, 0, &mut gradient);
            });
            let mut out = vec![0.0; rows * 23];
            let act = seconds(|| network.forward_many(&inputs, &mut out));
            let flops = [flop(0, rows), flop(1, rows), flop(0, rows)];
            println!(
                "{set:>9} {rows:>5} {peak:>7.1} {:>8.1} {:>9.1} {:>10.1} {:>8.1} {:>6.1}",
                flops[0] / forward,
                flops[1] / backward,
                flops[2] / by_weight,
                flops.iter().sum::<f64>() / all,
                flops[0] / act,
            );
        }
        if set == InstructionSet::chosen() {
            let network = Perceptron::new(sizes.clone(), parameters.clone());
            for rows in [1, 4, 16] {
                let (inputs, mut out) = (vec![0.1; rows * 160], vec![0.0; rows * 23]);
                let mut between = Default::default();
                let time = seconds(|| (0..100).for_each(|_| network.forward(&inputs, &mut between, &mut out))) / 100.0;
                println!("{rows:>3} rows as they come: {:.1} us, {:.1} Gflop/s", 1e6 * time, flop(0, rows) / time);
            }
        }
    }
}
