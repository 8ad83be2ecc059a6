//! Times of a residual block, forward and backward: `cargo run --release -p lifelike-nn --example layers -- [tune]` (`tune`: with the
//! allocator setting).
//!
//! Prints the median and the best of several steps.

mod stopwatch;

use lifelike_nn::conv_resnet::{Conv3, ResBlock, add_block, add_conv3};
use lifelike_nn::memory;
use lifelike_nn::parameters::ParameterList;
use stopwatch::{random, time};

/// Time steps.
const STEPS: usize = 16;

fn main() {
    if std::env::args().any(|a| a == "tune") {
        println!("allocator tuned: {}", memory::tune_allocator());
    }
    for (batch, channels) in [(128, 48), (512, 104)] {
        let mut list = ParameterList::default();
        add_block(&mut list, "block", channels, 0, "bench");
        add_conv3(&mut list, "conv", [channels; 2], 0, "bench");
        let parameters = list.finish();
        let x = random(STEPS * batch * channels);
        let block = ResBlock::new("block", channels, &parameters);
        let mut sums = vec![0.0; parameters.len()];
        time(&format!("ResBlock {channels} channels, {batch} x {STEPS} steps, one thread, both ways"), 15, || {
            let (y, pass) = block.forward(x.clone(), STEPS);
            block.backward(&pass, y, STEPS, &mut sums);
        });
        let conv = Conv3::new("conv", [channels; 2], &parameters);
        time("  of it Conv3", 15, || {
            let y = conv.forward(&x, STEPS);
            conv.backward(&x, &y, STEPS, &mut sums);
        });
    }
}
