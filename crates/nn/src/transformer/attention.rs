//! Attention of every token to every token.

use burn::module::{Module, Param};
use burn::tensor::activation::softmax;
use burn::tensor::{Device, Tensor};

use super::heads::weight;

/// Multi-head self-attention with an additive bias per head, and no other bias: T5's projections have none.
///
/// T5 leaves out the factor 1/√(c/h) and draws the query weights smaller by it instead. At initialization that is the same
/// function; here the factor stays, so that Adam's steps, which do not know how small a weight began, are not √(c/h) times
/// as effective on queries as on everything else.
///
/// `projection` is `[c, 3c]`: queries, keys, values, each head by head. `output` is `[c, c]`.
#[derive(Module, Debug)]
pub struct Attention {
    pub(crate) projection: Param<Tensor<2>>,
    pub(crate) output: Param<Tensor<2>>,
    #[module(skip)]
    pub(crate) heads: usize,
}

impl Attention {
    /// Returns normal weights of standard deviation 1/√c from the streams `(seed, purpose.NAME, 0, 0)`. `heads` must divide
    /// `width`, which [`super::AutoencoderConfig`] checks.
    pub fn new(width: usize, heads: usize, seed: u64, purpose: &str, device: &Device) -> Self {
        Self {
            projection: weight(width, 3 * width, seed, &format!("{purpose}.projection"), device),
            output: weight(width, width, seed, &format!("{purpose}.output"), device),
            heads,
        }
    }

    /// # Shapes
    /// `x: [B, T, c]`, `bias: [h, T, T]` to `[B, T, c]`.
    pub fn forward(&self, x: Tensor<3>, bias: Tensor<3>) -> Tensor<3> {
        let [b, t, c] = x.dims();
        let (h, size) = (self.heads, c / self.heads);
        let all = x.reshape([b * t, c]).matmul(self.projection.val());
        // Views: the products below take any strides, so no head is copied.
        let part = |i: usize| all.clone().narrow(1, i * c, c).reshape([b, t, h, size]).swap_dims(1, 2);
        let queries = part(0).mul_scalar((size as f64).powf(-0.5));
        let scores = queries.matmul(part(1).transpose()) + bias.unsqueeze::<4>();
        let mixed = softmax(scores, 3).matmul(part(2));
        mixed.swap_dims(1, 2).reshape([b * t, c]).matmul(self.output.val()).reshape([b, t, c])
    }
}
