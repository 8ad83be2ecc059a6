//! Per-token maps with biases before, between and after the transformer blocks.

use burn::module::{Module, Param};
use burn::tensor::activation::gelu;
use burn::tensor::{Device, Tensor};

use crate::init;
use lifelike_checkpoint::rng;

/// A linear map and a bias, the same for every token. `weight` is `[inputs, outputs]`.
#[derive(Module, Debug)]
pub struct Affine {
    pub(crate) weight: Param<Tensor<2>>,
    pub(crate) bias: Param<Tensor<1>>,
}

impl Affine {
    /// Returns normal weights of standard deviation 1/√inputs from the stream `(seed, purpose, 0, 0)`, bias 0.
    pub fn new(inputs: usize, outputs: usize, seed: u64, purpose: &str, device: &Device) -> Self {
        Self {
            weight: weight(inputs, outputs, seed, purpose, device),
            bias: init::parameter(vec![0.0; outputs], [outputs], device),
        }
    }

    /// # Shapes
    /// `[B, T, inputs]` to `[B, T, outputs]`.
    pub fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        let [b, t, c] = x.dims();
        let outputs = self.weight.dims()[1];
        let y = x.reshape([b * t, c]).matmul(self.weight.val()) + self.bias.val().unsqueeze::<2>();
        y.reshape([b, t, outputs])
    }
}

/// The perceptron that makes tokens out of the sequence's elements: one hidden layer as wide as the tokens, GELU inside.
///
/// For elements that are image patches this is the thesis' patch CNN: a convolution whose stride is its kernel, then one of
/// kernel 1 ([`super::patches`] lays the patches out).
#[derive(Module, Debug)]
pub struct InputHead {
    pub(crate) hidden: Affine,
    pub(crate) output: Affine,
}

impl InputHead {
    /// From `inputs` numbers to tokens of `width`; the streams are addressed by `purpose`.
    pub fn new(inputs: usize, width: usize, seed: u64, purpose: &str, device: &Device) -> Self {
        Self {
            hidden: Affine::new(inputs, width, seed, &format!("{purpose}.hidden"), device),
            output: Affine::new(width, width, seed, &format!("{purpose}.output"), device),
        }
    }

    /// # Shapes
    /// `[B, T, inputs]` to `[B, T, width]`.
    pub fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        self.output.forward(gelu(self.hidden.forward(x)))
    }
}

/// Returns normal weights `[inputs, outputs]` of standard deviation 1/√inputs (T5's) from the stream `(seed, purpose, 0, 0)`.
pub(crate) fn weight(inputs: usize, outputs: usize, seed: u64, purpose: &str, device: &Device) -> Param<Tensor<2>> {
    let deviation = (inputs.max(1) as f64).powf(-0.5);
    let values = init::normal(&mut rng::stream(seed, purpose, 0, 0), inputs * outputs, deviation);
    init::parameter(values, [inputs, outputs], device)
}
