//! A perceptron of one hidden layer, in two calls: `cargo run --release -p lifelike-dense --example perceptron`.

use lifelike_dense::{elu, product};

fn main() {
    let (rows, hidden, outputs) = (2, 4, 1);
    let inputs = [0.5, -1.0, 2.0, 0.1];
    let first: Vec<f32> = (0..8).map(|i| 0.25 * i as f32 - 1.0).collect();
    let second = [1.0, -1.0, 0.5, 2.0];
    let mut activations = vec![0.0; rows * hidden];
    product(&inputs, &first, [rows, 2, hidden], &mut activations);
    activations.iter_mut().for_each(|x| *x = elu(*x));
    let mut out = vec![0.0; rows * outputs];
    product(&activations, &second, [rows, hidden, outputs], &mut out);
    println!("{out:?}");
}
