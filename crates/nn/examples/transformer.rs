//! Times of transformer blocks and of whole networks, forward and backward:
//! `cargo run --release -p lifelike-nn --example transformer -- [plain]` (`plain`: without the allocator setting).
//!
//! Prints the median and the best of several runs.

mod stopwatch;

use lifelike_nn::gradients::Gradients;
use lifelike_nn::transformer::backprop::{PassError, Weights};
use lifelike_nn::transformer::{Attention, AutoencoderConfig, Block, alibi};
use lifelike_nn::{device, memory};
use rayon::prelude::*;
use stopwatch::{random, time};

fn main() {
    if !std::env::args().any(|a| a == "plain") {
        println!("allocator tuned: {}", memory::tune_allocator());
    }
    for (batch, tokens, width, heads) in [(64, 64, 64, 4), (64, 100, 128, 8), (64, 256, 64, 4)] {
        let name = format!("B {batch}, T {tokens}, c {width}, h {heads}, forward + backward");
        let positions: Vec<f64> = (0..tokens).map(|i| i as f64).collect();
        let bias = alibi::bias_tensor(heads, &positions, &device::training());
        let x = random([batch, tokens, width]).require_grad();
        let module = Attention::new(width, heads, 0, "bench", &device::training());
        time(&format!("attention {name}"), 15, || {
            Gradients::of(&module, module.forward(x.clone(), bias.clone()).square().mean().backward());
        });
        let module = Block::new(width, heads, 1, 0, "bench", &device::training());
        time(&format!("block {name}"), 15, || {
            Gradients::of(&module, module.forward(x.clone(), bias.clone()).square().mean().backward());
        });
    }
    for (batch, tokens, inputs, latent, layers, heads, width) in
        [(64, 256, 2, 3, 4, 4, 64), (64, 64, 66, 64, 4, 8, 128)]
    {
        let config = AutoencoderConfig::new(inputs, latent, layers, heads, width);
        let network = match config.init(0, "bench", &device::training()) {
            Ok(network) => network,
            Err(error) => return println!("{error}"),
        };
        let x = random([batch, tokens, inputs]);
        let name =
            format!("autoencoder B {batch}, T {tokens}, D {inputs}, d {latent}, n {layers}, h {heads}, c {width}");
        time(&format!("{name}, recorded, forward + backward"), 7, || match network.forward(x.clone()) {
            Ok(y) => drop(Gradients::of(&network, y.square().mean().backward())),
            Err(error) => println!("{error}"),
        });
        let values: Vec<f32> = x.try_into_vec_as().unwrap_or_default();
        let pass = |weights: &Weights, x: &[f32]| -> Result<Vec<f32>, PassError> {
            let (y, pass) = weights.forward(x.to_vec(), tokens)?;
            let scale = 2.0 / values.len() as f32;
            let by_sequence: Vec<f32> = y.sequence.into_iter().map(|y| y * scale).collect();
            weights.backward(pass, &by_sequence, None)
        };
        let parts_of = |size: usize| -> Result<(), PassError> {
            let weights = Weights::of(&network)?;
            let parts: Vec<&[f32]> = values.chunks(size * tokens * inputs).collect();
            parts.into_par_iter().try_for_each(|x| pass(&weights, x).map(drop))
        };
        time(&format!("{name}, by hand, forward + backward"), 7, || {
            if let Err(error) = parts_of(batch) {
                println!("{error}");
            }
        });
        // As trainings do it: a core for each part of the batch.
        time(&format!("{name}, by hand in parts of 8, forward + backward"), 7, || {
            if let Err(error) = parts_of(8) {
                println!("{error}");
            }
        });
    }
}
