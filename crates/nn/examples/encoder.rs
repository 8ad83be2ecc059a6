//! Time of one training step of MDM's encoder (forward and backward, sequences of different lengths): `cargo run
//! --release -p lifelike-nn --example encoder -- [0, 1 or 2: one of the sizes only]`. `peers/encoder/step.py` is
//! PyTorch's.

#[allow(dead_code)] // its random numbers are for the other examples
mod stopwatch;

use lifelike_nn::memory;
use lifelike_nn::rows::Layout;
use lifelike_nn::transformer::encoder::{Encoder, EncoderSizes};
use rayon::prelude::*;
use stopwatch::time;

fn main() {
    println!("allocator tuned: {}", memory::tune_allocator());
    let only: Option<usize> = std::env::args().nth(1).and_then(|text| text.parse().ok());
    let all = [(64, 30, 75, 128, 4, 4, 512), (64, 80, 220, 128, 4, 4, 512), (16, 80, 220, 512, 8, 4, 1024)];
    for (i, (batch, shortest, longest, width, layers, heads, inner)) in all.into_iter().enumerate() {
        if only.is_some_and(|only| only != i) {
            continue;
        }
        let sizes = EncoderSizes { width, layers, heads, inner };
        let Ok(entries) = sizes.entries("encoder") else { return println!("no such encoder") };
        let layout = Layout::new(entries);
        let values = layout.init(0, "bench");
        let lengths: Vec<usize> = (0..batch).map(|i| shortest + i * 37 % (longest - shortest + 1)).collect();
        let name = format!("encoder B {batch}, T {shortest}..{longest}, c {width}, n {layers}, h {heads}, ff {inner}");
        time(&format!("{name}, forward + backward"), 7, || {
            let encoder = Encoder::new(sizes, &layout, "encoder", &values);
            let parts: Vec<&[usize]> = lengths.chunks(8).collect();
            let gradients: Vec<Vec<f32>> = parts
                .into_par_iter()
                .map(|lengths| {
                    let rows: usize = lengths.iter().sum();
                    let x = (0..rows * width).map(|i| ((i * 31) % 101) as f32 * 0.02 - 1.0).collect();
                    let (y, pass) = encoder.forward(x, lengths);
                    let mut sums = vec![0.0; layout.len()];
                    encoder.backward(pass, y, &mut sums);
                    sums
                })
                .collect();
            let mut total = vec![0.0_f32; layout.len()];
            for sums in gradients {
                total.iter_mut().zip(sums).for_each(|(total, x)| *total += x);
            }
        });
    }
}
