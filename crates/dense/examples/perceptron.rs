//! A frozen perceptron of one hidden layer: `cargo run --release -p lifelike-dense --example perceptron`.

use lifelike_dense::{Between, Perceptron, Sizes};

fn main() {
    let sizes = Sizes::new(&[2, 4, 1]);
    // Weight and bias of the hidden layer, then of the output.
    let parameters: Vec<f32> = (0..sizes.parameters()).map(|i| 0.25 * i as f32 - 1.0).collect();
    let network = Perceptron::new(sizes, parameters);
    let (inputs, mut outputs) = ([0.5, -1.0, 2.0, 0.1], [0.0; 2]);
    network.forward(&inputs, &mut Between::default(), &mut outputs);
    println!("{outputs:?}");
}
