//! The gradient of an [`Mlp`] by hand: the chain rule written out, without a recorded graph.
//!
//! For networks on a card: automatic differentiation computes an ELU and its derivative in a dozen passes over memory,
//! written out it is two. The products are the tensor library's; a test holds the result against automatic differentiation. On a
//! CPU the same is `lifelike_dense`'s.
//!
//! Rows come from our own memory and go back to it, and everything between is where the network is: a minibatch crosses to a
//! card and back once.

use burn::tensor::{Device, Tensor, TensorData};

use crate::elu::elu;
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
/// Tensor data that cannot be read from the device.
pub fn forward(mlp: &Mlp, x: Vec<f32>) -> Result<(Vec<f32>, Pass), Unreadable> {
    let mut inputs = Vec::with_capacity(mlp.layers().len());
    let batch = x.len() / mlp.inputs().max(1);
    let mut x = tensor(x, [batch, mlp.inputs()], &mlp.device());
    for (i, layer) in mlp.layers().iter().enumerate() {
        let weight = layer.weight.val().without_autodiff();
        let bias = layer.bias.as_ref().map(|b| b.val().without_autodiff());
        let hidden = i + 1 < mlp.layers().len();
        inputs.push(x.clone());
        x = finish(x.matmul(weight), bias, hidden);
    }
    Ok((read(x)?, Pass { inputs }))
}

/// Gradients of all parameters, named as in a module that holds this one under `prefix` (`"mean"`; empty: none).
///
/// # Shapes
/// `gradient: [B, outputs]`, row-major: the loss's derivative by each output.
///
/// # Errors
/// Tensor data that cannot be read from the device.
pub fn backward(mlp: &Mlp, pass: Pass, gradient: Vec<f32>, prefix: &str) -> Result<Gradients, Unreadable> {
    Ok(descend(mlp, pass, gradient, prefix, false)?.0)
}

/// As [`backward`], and the loss's derivative by each input, `[B, inputs]`: for a network that follows another one.
///
/// # Errors
/// Tensor data that cannot be read from the device.
pub fn backward_through(
    mlp: &Mlp,
    pass: Pass,
    gradient: Vec<f32>,
    prefix: &str,
) -> Result<(Gradients, Vec<f32>), Unreadable> {
    descend(mlp, pass, gradient, prefix, true)
}

/// Gradients, and the gradient at the input where it is asked for (a product as large as the first layer's).
fn descend(
    mlp: &Mlp,
    pass: Pass,
    gradient: Vec<f32>,
    prefix: &str,
    through: bool,
) -> Result<(Gradients, Vec<f32>), Unreadable> {
    let mut gradients = Gradients::default();
    let batch = gradient.len() / mlp.outputs().max(1);
    let mut gradient = tensor(gradient, [batch, mlp.outputs()], &mlp.device());
    for ((i, layer), input) in mlp.layers().iter().enumerate().zip(pass.inputs).rev() {
        let name = |part: &str| match prefix {
            "" => format!("layers.{i}.{part}"),
            _ => format!("{prefix}.layers.{i}.{part}"),
        };
        let weight = layer.weight.val().without_autodiff();
        let [rows, columns] = weight.dims();
        if layer.bias.is_some() {
            gradients.insert(name("bias"), gradient.clone().sum_dim(0).reshape([columns]));
        }
        let by_weight = input.clone().transpose().matmul(gradient.clone());
        gradients.insert(name("weight"), by_weight.reshape([rows * columns]));
        if i == 0 && !through {
            return Ok((gradients, Vec::new()));
        }
        gradient = gradient.matmul(weight.transpose());
        if i > 0 {
            // The derivative of an ELU whose value is h: 1 above zero, exp(x) = h + 1 below.
            gradient = gradient * (input.clamp_max(0.0) + 1.0);
        }
    }
    Ok((gradients, read(gradient)?))
}

/// Adds the bias, and in a hidden layer applies the ELU.
fn finish(y: Tensor<2>, bias: Option<Tensor<1>>, hidden: bool) -> Tensor<2> {
    let y = match bias {
        Some(bias) => y + bias.unsqueeze(),
        None => y,
    };
    if hidden { elu(y) } else { y }
}

fn tensor(values: Vec<f32>, shape: [usize; 2], device: &Device) -> Tensor<2> {
    Tensor::from_data(TensorData::new(values, shape), device)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::device::{self, Processor};
    use crate::mlp::MlpConfig;
    use burn::module::Module;

    #[test]
    fn values_and_gradients_are_those_of_automatic_differentiation() {
        let recorded = MlpConfig::new(7, &[33, 20], 3).init(1, "test", &device::training());
        agrees(&recorded, &recorded);
    }

    #[test]
    fn every_device_of_this_build_computes_the_same() {
        let recorded = MlpConfig::new(7, &[33, 20], 3).init(1, "test", &device::training());
        for processor in Processor::built() {
            agrees(&recorded, &recorded.clone().fork(&processor.open().unwrap()));
        }
    }

    /// The passes of `mlp` against automatic differentiation of `recorded`, the same network on the CPU.
    fn agrees(recorded: &Mlp, mlp: &Mlp) {
        let close = |a: f32, b: f32, what: &str| assert!((a - b).abs() <= 2e-5 * b.abs().max(1.0), "{what}: {a} {b}");
        let x: Vec<f32> = (0..5 * 7).map(|i| ((i * 37) % 23) as f32 * 0.2 - 2.0).collect();
        let gradient: Vec<f32> = (0..5 * 3).map(|i| ((i * 11) % 7) as f32 - 3.0).collect();

        let recorded_x = tensor(x.clone(), [5, 7], &device::training()).require_grad();
        let values = recorded.forward(recorded_x.clone());
        let loss = (values.clone() * tensor(gradient.clone(), [5, 3], &device::training())).sum();
        let mut tape = loss.backward();
        let by_input = read(recorded_x.grad_remove(&mut tape).unwrap()).unwrap();
        let expected = Gradients::of(recorded, tape);

        let (value, pass) = forward(mlp, x).unwrap();
        for (a, b) in value.iter().zip(read(values.without_autodiff()).unwrap()) {
            close(*a, b, "value");
        }
        let got = backward(mlp, pass.clone(), gradient.clone(), "").unwrap();
        let (again, through) = backward_through(mlp, pass, gradient, "").unwrap();
        assert_eq!(again.names().count(), got.names().count());
        assert_eq!(through.len(), by_input.len());
        for (a, b) in through.iter().zip(by_input) {
            close(*a, b, "by input");
        }
        assert_eq!(got.names().collect::<Vec<_>>(), expected.names().collect::<Vec<_>>());
        for name in expected.names() {
            let (a, b) = (got.get(name).unwrap().clone(), expected.get(name).unwrap().clone().without_autodiff());
            for (a, b) in read(a).unwrap().into_iter().zip(read(b).unwrap()) {
                close(a, b, name);
            }
        }
    }
}
