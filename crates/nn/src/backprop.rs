//! The gradient of an [`Mlp`] by hand: the chain rule written out, without a recorded graph.
//!
//! Reinforcement learning on a CPU spends its time on small perceptrons. Automatic differentiation computes an ELU and its
//! derivative in a dozen passes over memory that take as long as the matrix products; written out it is two. The products
//! are the tensor library's; a test holds the result against automatic differentiation.

use burn::tensor::{Device, Tensor, TensorData};

use crate::gradients::Gradients;
use crate::mlp::Mlp;
use crate::numbers::{Unreadable, read};

/// The inputs of each layer of one forward pass: what the backward pass needs.
#[derive(Debug, Clone)]
pub struct Pass {
    inputs: Vec<Tensor<2>>,
}

/// As [`Mlp::forward`] outside automatic differentiation, with fewer passes over memory.
///
/// # Shapes
/// `x: [B, inputs]`, row-major, to `[B, outputs]`.
///
/// # Errors
/// The device does not hand out its numbers.
pub fn forward(mlp: &Mlp, x: Vec<f32>, device: &Device) -> Result<(Vec<f32>, Pass), Unreadable> {
    let mut inputs = Vec::with_capacity(mlp.layers().len());
    let mut x = x;
    for (i, layer) in mlp.layers().iter().enumerate() {
        let weight = layer.weight.val().without_autodiff();
        let [rows, columns] = weight.dims();
        let bias = layer.bias.as_ref().map(|b| read(b.val().without_autodiff())).transpose()?;
        let batch = x.len() / rows.max(1);
        let input = tensor(x, [batch, rows], device);
        let mut y = read(input.clone().matmul(weight))?;
        let hidden = i + 1 < mlp.layers().len();
        for row in y.chunks_exact_mut(columns.max(1)) {
            if let Some(bias) = &bias {
                row.iter_mut().zip(bias).for_each(|(y, b)| *y += b);
            }
            if hidden {
                row.iter_mut().for_each(|y| *y = elu(*y));
            }
        }
        inputs.push(input);
        x = y;
    }
    Ok((x, Pass { inputs }))
}

/// Gradients of all parameters, named as in a module that holds this one under `prefix` (`"mean"`; empty: none).
///
/// # Shapes
/// `slope: [B, outputs]`, row-major: the loss's derivative by each output.
///
/// # Errors
/// The device does not hand out its numbers.
pub fn backward(
    mlp: &Mlp,
    pass: Pass,
    slope: Vec<f32>,
    prefix: &str,
    device: &Device,
) -> Result<Gradients, Unreadable> {
    Ok(descend(mlp, pass, slope, prefix, device, false)?.0)
}

/// As [`backward`], and the loss's derivative by each input, `[B, inputs]`: for a network that follows another one.
///
/// # Errors
/// The device does not hand out its numbers.
pub fn backward_through(
    mlp: &Mlp,
    pass: Pass,
    slope: Vec<f32>,
    prefix: &str,
    device: &Device,
) -> Result<(Gradients, Vec<f32>), Unreadable> {
    descend(mlp, pass, slope, prefix, device, true)
}

/// Gradients, and the slope at the input where it is asked for (a product as large as the first layer's).
fn descend(
    mlp: &Mlp,
    pass: Pass,
    slope: Vec<f32>,
    prefix: &str,
    device: &Device,
    through: bool,
) -> Result<(Gradients, Vec<f32>), Unreadable> {
    let mut gradients = Gradients::default();
    let mut slope = slope;
    for ((i, layer), input) in mlp.layers().iter().enumerate().zip(pass.inputs).rev() {
        let name = |part: &str| match prefix {
            "" => format!("layers.{i}.{part}"),
            _ => format!("{prefix}.layers.{i}.{part}"),
        };
        let weight = layer.weight.val().without_autodiff();
        let [rows, columns] = weight.dims();
        if layer.bias.is_some() {
            let mut sums = vec![0.0_f32; columns];
            for row in slope.chunks_exact(columns.max(1)) {
                sums.iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
            }
            gradients.insert(name("bias"), Tensor::from_data(TensorData::new(sums, [columns]), device));
        }
        let batch = slope.len() / columns.max(1);
        let after = tensor(slope, [batch, columns], device);
        let by_weight = input.clone().transpose().matmul(after.clone());
        gradients.insert(name("weight"), by_weight.reshape([rows * columns]));
        if i == 0 && !through {
            return Ok((gradients, Vec::new()));
        }
        slope = read(after.matmul(weight.transpose()))?;
        if i == 0 {
            break;
        }
        // The input is the ELU's value h of the layer below: its derivative is 1 above zero and exp(x) = h + 1 below.
        let below = read(input)?;
        slope.iter_mut().zip(&below).for_each(|(slope, h)| *slope *= h.min(0.0) + 1.0);
    }
    Ok((gradients, slope))
}

fn tensor(values: Vec<f32>, shape: [usize; 2], device: &Device) -> Tensor<2> {
    Tensor::from_data(TensorData::new(values, shape), device)
}

/// x above zero, exp(x) − 1 below.
fn elu(x: f32) -> f32 {
    let below = exp_of_nonpositive(x.min(0.0)) - 1.0;
    if x > 0.0 { x } else { below }
}

/// exp(x) for x ≤ 0 to about one unit in the last place, in operations that a compiler turns into vector instructions
/// (the library's function is a call per number): x = n ln 2 + r with |r| ≤ ½ ln 2, a polynomial for exp(r) (Cephes), and
/// the exponent n put together from bits.
fn exp_of_nonpositive(x: f32) -> f32 {
    // Below this the result is no normal number; as an ELU it is −1 long before.
    let x = x.max(-87.0);
    // Adding and taking away 1.5 · 2²³ rounds to the nearest whole number.
    let magic = 12_582_912.0_f32;
    let n = (x * std::f32::consts::LOG2_E + magic) - magic;
    let r = n.mul_add(-0.693_359_4, x);
    let r = n.mul_add(2.121_944_4e-4, r);
    let mut p = 1.987_569_1e-4_f32;
    for c in [1.398_199_9e-3, 8.333_452e-3, 4.166_579_6e-2, 1.666_666_5e-1, 5e-1] {
        p = p.mul_add(r, c);
    }
    let p = p.mul_add(r * r, r) + 1.0;
    p * f32::from_bits(((n as i32 + 127) as u32) << 23)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::device;
    use crate::mlp::MlpConfig;

    #[test]
    fn the_exponential_is_right_to_the_last_digits() {
        for i in 0..200_000 {
            let x = -i as f32 * 4.3e-4;
            let (got, exact) = (f64::from(exp_of_nonpositive(x)), f64::from(x).exp());
            assert!((got - exact).abs() <= 1.5e-7 * exact, "exp({x}) = {got}, not {exact}");
        }
        assert_eq!((elu(0.0), elu(2.5), elu(f32::NEG_INFINITY)), (0.0, 2.5, -1.0));
        assert!(elu(-1e-3) < 0.0 && elu(f32::MAX) == f32::MAX);
    }

    #[test]
    fn values_and_gradients_are_those_of_automatic_differentiation() {
        let mlp = MlpConfig::new(7, &[33, 20], 3).init(1, "test", &device::training());
        let x: Vec<f32> = (0..5 * 7).map(|i| ((i * 37) % 23) as f32 * 0.2 - 2.0).collect();
        let slope: Vec<f32> = (0..5 * 3).map(|i| ((i * 11) % 7) as f32 - 3.0).collect();
        let plain = device::inference();

        let recorded_x = tensor(x.clone(), [5, 7], &device::training()).require_grad();
        let recorded = mlp.forward(recorded_x.clone());
        let loss = (recorded.clone() * tensor(slope.clone(), [5, 3], &device::training())).sum();
        let mut tape = loss.backward();
        let by_input = read(recorded_x.grad_remove(&mut tape).unwrap()).unwrap();
        let expected = Gradients::of(&mlp, tape);

        let (value, pass) = forward(&mlp, x, &plain).unwrap();
        for (a, b) in value.iter().zip(read(recorded.without_autodiff()).unwrap()) {
            assert!((a - b).abs() <= 1e-5 * b.abs().max(1.0), "{a} {b}");
        }
        let got = backward(&mlp, pass.clone(), slope.clone(), "", &plain).unwrap();
        let (again, through) = backward_through(&mlp, pass, slope, "", &plain).unwrap();
        assert_eq!(again.names().count(), got.names().count());
        assert_eq!(through.len(), by_input.len());
        for (a, b) in through.iter().zip(by_input) {
            assert!((a - b).abs() <= 2e-5 * b.abs().max(1.0), "by input: {a} {b}");
        }
        assert_eq!(got.names().collect::<Vec<_>>(), expected.names().collect::<Vec<_>>());
        for name in expected.names() {
            let (a, b) = (got.get(name).unwrap().clone(), expected.get(name).unwrap().clone().without_autodiff());
            for (a, b) in read(a).unwrap().into_iter().zip(read(b).unwrap()) {
                assert!((a - b).abs() <= 2e-5 * b.abs().max(1.0), "{name}: {a} {b}");
            }
        }
    }
}
