//! The Spline-based Transformer (thesis Algorithm 2, Fig. 3.1) and, with other [`LatentTokens`], its baselines.

use burn::module::{Module, Param};
use burn::tensor::{Device, Tensor};

use super::alibi;
use super::block::Stack;
use super::config::{AutoencoderConfig, NetworkError};
use super::heads::{Affine, InputHead};
use super::latent::LatentTokens;
use super::sampling::Sampling;
use crate::init;
use crate::spline::SplineError;
use lifelike_checkpoint::rng;

/// A sequence to a few latent control points and back.
///
/// Encoder: each element through [`InputHead`], control tokens put BEFORE the sequence (Algorithm 2, line 9; for the ALiBi
/// bias they stand at positions −P to −1), blocks, and a linear map of the control tokens to the latent dimension. Decoder:
/// latent tokens, a linear map to the width, blocks, a linear map to the element ("the last MLP of the decoder", the one
/// layer without GELU).
///
/// # Parameters of thesis Table A.1
/// Blocks without biases (6 c² for attention and feed-forward, factor 1, and 2 c of gains), n of them on either side, a
/// gain at the end of either stack, biases in every [`Affine`], and ONE hidden layer of c² beside the blocks (in the input
/// head) give the table's counts to its last digit for curves, strands and CIFAR-10, and 1.3% less for AFHQ and faces in
/// images (their CNN is not described). With biases in the blocks CIFAR-10 would have 0.86M, with a second hidden layer
/// the curves 0.21M. Two rows follow from no reading with the table's n and c: 8 blocks of width 128 alone are 0.79M, but
/// Bézier (64D) is given 0.43M, which is what n = 2 has, and motion 0.63M, which is within 2% of n = 3. A decoder of width 2 c
/// (ALiBi-Cat by the text of 3.3) has 0.50M for Lissajous curves: the table's 0.20M is no count of it.
/// `tests/transformer_sizes.rs` holds all of this.
#[derive(Module, Debug)]
pub struct SplineAutoencoder {
    pub(crate) input: InputHead,
    pub(crate) control: Param<Tensor<2>>,
    pub(crate) encoder: Stack,
    pub(crate) to_latent: Affine,
    pub(crate) from_latent: Affine,
    pub(crate) decoder: Stack,
    pub(crate) output: Affine,
    #[module(skip)]
    pub(crate) tokens: LatentTokens,
    #[module(skip)]
    pub(crate) heads: usize,
}

impl AutoencoderConfig {
    /// Returns the network, its weights from streams addressed by `seed` and `purpose`.
    ///
    /// # Errors
    /// Sizes that do not make a network.
    pub fn init(&self, seed: u64, purpose: &str, device: &Device) -> Result<SplineAutoencoder, NetworkError> {
        self.check()?;
        Ok(SplineAutoencoder::new(self, seed, purpose, device))
    }
}

impl SplineAutoencoder {
    fn new(config: &AutoencoderConfig, seed: u64, purpose: &str, device: &Device) -> Self {
        let (c, d) = (config.width, config.latent);
        let name = |part: &str| format!("{purpose}.{part}");
        let wide = config.tokens.decoder_width(c);
        let stack = |part: &str, width: usize| {
            Stack::new(config.layers, [width, config.heads, config.factor], seed, &name(part), device)
        };
        let points = config.tokens.control_points();
        let control = init::normal(&mut rng::stream(seed, &name("control"), 0, 0), points * c, 1.0);
        Self {
            input: InputHead::new(config.inputs, c, seed, &name("input"), device),
            control: init::parameter(control, [points, c], device),
            encoder: stack("encoder", c),
            to_latent: Affine::new(c, d, seed, &name("to_latent"), device),
            from_latent: Affine::new(config.tokens.width(d), wide, seed, &name("from_latent"), device),
            decoder: stack("decoder", wide),
            output: Affine::new(wide, config.inputs, seed, &name("output"), device),
            tokens: config.tokens.clone(),
            heads: config.heads,
        }
    }

    /// # Shapes
    /// `[B, T, inputs]` to control points `[B, P, d]`.
    pub fn encode(&self, x: Tensor<3>) -> Tensor<3> {
        let [b, t, _] = x.dims();
        let [points, c] = self.control.dims();
        let control = self.control.val().unsqueeze::<3>().expand([b, points, c]);
        let all = Tensor::cat(vec![control, self.input.forward(x)], 1);
        let bias = alibi::bias_tensor(self.heads, &positions(points, t), &all.device());
        self.to_latent.forward(self.encoder.forward(all, bias).narrow(1, 0, points))
    }

    /// # Shapes
    /// Control points `[B, P, d]` to `[B, sampling, inputs]`.
    ///
    /// # Errors
    /// Another number of control points.
    pub fn decode(&self, control_points: Tensor<3>, sampling: &Sampling) -> Result<Tensor<3>, SplineError> {
        let tokens = self.from_latent.forward(self.tokens.tokens(control_points, sampling)?);
        let bias = alibi::bias_tensor(self.heads, sampling.positions(), &tokens.device());
        Ok(self.output.forward(self.decoder.forward(tokens, bias)))
    }

    /// Encodes and decodes a sequence.
    ///
    /// # Shapes
    /// `[B, T, inputs]` to the same.
    ///
    /// # Errors
    /// None for a network made by [`AutoencoderConfig::init`].
    pub fn forward(&self, x: Tensor<3>) -> Result<Tensor<3>, SplineError> {
        let sampling = Sampling::each(x.dims()[1]);
        self.decode(self.encode(x), &sampling)
    }

    /// Returns the kind of the decoder's tokens.
    pub fn tokens(&self) -> &LatentTokens {
        &self.tokens
    }
}

/// Returns the positions of control tokens and sequence for the ALiBi bias.
pub(crate) fn positions(points: usize, tokens: usize) -> Vec<f64> {
    (0..points + tokens).map(|i| i as f64 - points as f64).collect()
}
