//! Times of a training step, with or without the allocator setting:
//! `cargo run --release -p lifelike-nn --example layers -- [tune]`.
//!
//! Prints the median and the best of several steps, and for the convolutions also burn's own `conv1d` on the same job.

mod stopwatch;

use burn::module::Module;
use burn::tensor::ops::ConvOptions;
use lifelike_nn::adam::{Adam, AdamConfig};
use lifelike_nn::conv_resnet::{Conv3, ResBlock};
use lifelike_nn::gradients::Gradients;
use lifelike_nn::mlp::MlpConfig;
use lifelike_nn::{device, memory};
use stopwatch::{random, time};

fn main() {
    if std::env::args().any(|a| a == "tune") {
        println!("allocator tuned: {}", memory::tune_allocator());
    }
    for (name, inputs, hidden, batch) in
        [("256x128", 244, vec![256, 128], 1536), ("512x3", 244, vec![512; 3], 1536), ("512x3", 244, vec![512; 3], 8192)]
    {
        let mut mlp = MlpConfig::new(inputs, &hidden, 20).init(0, "bench", &device::training());
        let mut adam = Adam::new(AdamConfig::adam());
        let x = random([batch, inputs]);
        time(&format!("MLP {name}, batch {batch}, forward + backward + Adam"), 15, || {
            let gradients = Gradients::of(&mlp, mlp.forward(x.clone()).square().mean().backward());
            mlp = adam.step(mlp.clone(), gradients, 1e-4);
        });
        let fixed = mlp.valid();
        let x = random([256, inputs]).inner();
        time(&format!("MLP {name}, inference of 256"), 15, || {
            std::hint::black_box(fixed.forward(x.clone()).into_data());
        });
    }
    for (batch, channels) in [(128, 48), (512, 104)] {
        let block = ResBlock::new(channels, 0, "bench", &device::training());
        let x = random([16, batch, channels]);
        time(&format!("ResBlock {channels} channels, {batch} x 16 steps, forward + backward"), 15, || {
            Gradients::of(&block, block.forward(x.clone()).square().mean().backward());
        });
        let conv = Conv3::new(channels, channels, 0, "bench", &device::training());
        time("  of it Conv3", 15, || {
            Gradients::of(&conv, conv.forward(x.clone()).square().mean().backward());
        });
        let weight = random([channels, channels, 3]).require_grad();
        let x = random([batch, channels, 16]).require_grad();
        time("  burn's conv1d for the same", 15, || {
            let options = ConvOptions::new([1], [1], [1], 1);
            let y = burn::tensor::module::conv1d(x.clone(), weight.clone(), None, options);
            std::hint::black_box(y.square().mean().backward());
        });
    }
}
