//! Times of whole networks, forward and backward:
//! `cargo run --release -p lifelike-nn --example transformer -- [plain]` (`plain`: without the allocator setting).
//!
//! Prints the median and the best of several runs.

mod stopwatch;

use lifelike_nn::memory;
use lifelike_nn::transformer::AutoencoderConfig;
use lifelike_nn::transformer::passes::{PassError, Weights};
use rayon::prelude::*;
use stopwatch::{random, time};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    if !std::env::args().any(|a| a == "plain") {
        println!("allocator tuned: {}", memory::tune_allocator());
    }
    for (batch, tokens, inputs, latent, layers, heads, width) in
        [(64, 256, 2, 3, 4, 4, 64), (64, 64, 66, 64, 4, 8, 128)]
    {
        let network = AutoencoderConfig::new(inputs, latent, layers, heads, width).init(0, "bench")?;
        let values = random(batch * tokens * inputs);
        let name =
            format!("autoencoder B {batch}, T {tokens}, D {inputs}, d {latent}, n {layers}, h {heads}, c {width}");
        let pass = |weights: &Weights, x: &[f32]| -> Result<Vec<f32>, PassError> {
            let (y, pass) = weights.forward(x.to_vec(), tokens)?;
            let scale = 2.0 / values.len() as f32;
            let by_sequence: Vec<f32> = y.sequence.into_iter().map(|y| y * scale).collect();
            weights.backward(pass, &by_sequence, None)
        };
        let parts_of = |size: usize| -> Result<(), PassError> {
            let weights = network.weights();
            let parts: Vec<&[f32]> = values.chunks(size * tokens * inputs).collect();
            parts.into_par_iter().try_for_each(|x| pass(&weights, x).map(drop))
        };
        // As trainings do it last: a core for each part of the batch.
        for size in [batch, 8] {
            time(&format!("{name}, in parts of {size}, forward + backward"), 7, || {
                if let Err(error) = parts_of(size) {
                    println!("{error}");
                }
            });
        }
    }
    Ok(())
}
