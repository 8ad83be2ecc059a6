//! The Spline-based Transformer (thesis Algorithm 2, Fig. 3.1) and, with other [`LatentTokens`], its baselines.

use lifelike_checkpoint::rng;

use super::config::{AutoencoderConfig, NetworkError};
use super::latent::LatentTokens;
use super::passes::PassError;
use super::passes::Weights;
use super::sampling::Sampling;
use crate::init;
use crate::parameters::{ParameterList, Parameters};

/// A sequence to a few latent control points and back.
///
/// Encoder: each element passes a perceptron of one hidden layer (GELU). Control tokens are put BEFORE the sequence
/// (Algorithm 2, line 9; for the ALiBi bias they stand at positions −P to −1). Blocks follow, and a linear map of the
/// control tokens to the latent dimension. Decoder: latent tokens, a linear map to the width, blocks, a linear map to
/// the element ("the last MLP of the decoder", without GELU).
///
/// # Parameters of thesis Table A.1
/// Counts agree to the last digit for curves, strands and CIFAR-10. They are 1.3% less for AFHQ and faces in images
/// (their CNN is not described). They follow from n blocks without biases on either side and a gain at the end of
/// either stack. A block has 6 c² for attention and feed-forward (factor 1), and 2 c of gains. Every map outside of
/// blocks has biases, and ONE hidden layer of c² is beside the blocks (in the input head). With biases in the blocks
/// CIFAR-10 would have 0.86M, with a second hidden layer the curves 0.21M. Two rows follow from no reading with the
/// table's n and c: 8 blocks of width 128 alone are 0.79M. Bézier (64D) is given 0.43M, which n = 2 has, and motion
/// 0.63M, which is within 2% of n = 3. A decoder of width 2 c (ALiBi-Cat by the text of 3.3) has 0.50M for Lissajous
/// curves: the table's 0.20M is no count of it. `tests/all/transformer_sizes.rs` holds all of this.
#[derive(Debug, Clone, PartialEq)]
pub struct SplineAutoencoder {
    config: AutoencoderConfig,
    parameters: Parameters,
}

impl AutoencoderConfig {
    /// Returns the network, its weights from streams addressed by `seed` and `purpose`.
    ///
    /// # Errors
    /// Sizes that do not make a network.
    pub fn init(&self, seed: u64, purpose: &str) -> Result<SplineAutoencoder, NetworkError> {
        self.check()?;
        let mut list = InitialWeights { list: ParameterList::default(), seed, purpose };
        list.network(self);
        Ok(SplineAutoencoder { config: self.clone(), parameters: list.list.finish() })
    }
}

impl SplineAutoencoder {
    /// Returns the sizes.
    pub fn config(&self) -> &AutoencoderConfig {
        &self.config
    }

    /// Returns the parameters.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Returns the parameters, to be changed.
    pub fn parameters_mut(&mut self) -> &mut Parameters {
        &mut self.parameters
    }

    /// Returns the network with other parameters of the same layout.
    #[must_use]
    pub fn with_parameters(self, parameters: Parameters) -> Self {
        Self { parameters, ..self }
    }

    /// Returns the kind of the decoder's tokens.
    pub fn tokens(&self) -> &LatentTokens {
        &self.config.tokens
    }

    /// Packs the parameters for passes.
    pub fn weights(&self) -> Weights {
        Weights::of(self)
    }

    /// Encodes and decodes sequences.
    ///
    /// # Shapes
    /// `[B, tokens, inputs]` to the same.
    ///
    /// # Errors
    /// Numbers that are not whole sequences.
    pub fn forward(&self, x: &[f32], tokens: usize) -> Result<Vec<f32>, PassError> {
        let weights = self.weights();
        weights.decode(&weights.encode(x, tokens)?, &Sampling::each(tokens))
    }
}

/// The parameters with their initial values: maps of normal weights with standard deviation 1/√inputs (T5's) from the streams
/// `(seed, purpose.NAME, 0, 0)`, biases 0, gains 1.
struct InitialWeights<'a> {
    list: ParameterList,
    seed: u64,
    purpose: &'a str,
}

impl InitialWeights<'_> {
    fn network(&mut self, config: &AutoencoderConfig) {
        let AutoencoderConfig { inputs, latent, layers, width, factor, ref tokens, .. } = *config;
        let wide = tokens.decoder_width(width);
        let points = tokens.control_points();
        self.affine("input.hidden", inputs, width);
        self.affine("input.output", width, width);
        let control = self.normal("control", points * width, 1.0);
        self.list.add("control", &[points, width], control);
        self.stack("encoder", layers, width, factor);
        self.affine("to_latent", width, latent);
        self.affine("from_latent", tokens.width(latent), wide);
        self.stack("decoder", layers, wide, factor);
        self.affine("output", wide, inputs);
    }

    /// Blocks and, because a pre-norm block leaves its sum as it is, one more normalization at the end (T5's `final_layer_norm`).
    fn stack(&mut self, name: &str, layers: usize, width: usize, factor: usize) {
        for layer in 0..layers {
            let (block, stream) = (format!("{name}.blocks.{layer}"), format!("{name}.{layer}"));
            self.gain(&format!("{block}.norm_1"), width);
            self.map(&block, &stream, "attention.projection", [width, 3 * width]);
            self.map(&block, &stream, "attention.output", [width, width]);
            self.gain(&format!("{block}.norm_2"), width);
            self.map(&block, &stream, "feed_forward.inner", [width, factor * width]);
            self.map(&block, &stream, "feed_forward.outer", [factor * width, width]);
        }
        self.gain(&format!("{name}.norm"), width);
    }

    fn map(&mut self, block: &str, stream: &str, part: &str, shape: [usize; 2]) {
        let values = self.normal(&format!("{stream}.{part}"), shape[0] * shape[1], deviation(shape[0]));
        self.list.add(format!("{block}.{part}"), &shape, values);
    }

    fn affine(&mut self, name: &str, inputs: usize, outputs: usize) {
        let values = self.normal(name, inputs * outputs, deviation(inputs));
        self.list.add(format!("{name}.weight"), &[inputs, outputs], values);
        self.list.add(format!("{name}.bias"), &[outputs], vec![0.0; outputs]);
    }

    fn gain(&mut self, name: &str, width: usize) {
        self.list.add(format!("{name}.gain"), &[width], vec![1.0; width]);
    }

    fn normal(&self, stream: &str, count: usize, deviation: f64) -> Vec<f32> {
        init::normal(&mut rng::stream(self.seed, &format!("{}.{stream}", self.purpose), 0, 0), count, deviation)
    }
}

fn deviation(inputs: usize) -> f64 {
    (inputs.max(1) as f64).powf(-0.5)
}

/// Returns the positions of control tokens and sequence for the ALiBi bias.
pub(crate) fn positions(points: usize, tokens: usize) -> Vec<f64> {
    (0..points + tokens).map(|i| i as f64 - points as f64).collect()
}
