//! Settings of a sequence autoencoder and of its training, as a TOML file.

use std::fmt;
use std::str::FromStr;

use lifelike_nn::adam::{AdamConfig, Rule};
use lifelike_nn::schedules::cosine;
use lifelike_nn::spline::CubicBezier;
use lifelike_nn::transformer::{AutoencoderConfig, LatentTokens};

use super::spread::Spread;
use crate::RepresentationError;
use lifelike_train::limits::{whole, wrong};
use lifelike_train::plan;

/// The thesis' method and what it is compared with.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Four control points of one cubic Bézier curve.
    Spline,
    /// One latent vector, sinusoids of the position added.
    Alibi,
    /// One latent vector, sinusoids of the position beside it, in a decoder as wide as the encoder.
    AlibiCat,
    /// As [`Self::AlibiCat`], in a decoder of twice that width.
    AlibiCatWide,
}

impl Method {
    /// All methods.
    pub const ALL: [Self; 4] = [Self::Alibi, Self::AlibiCat, Self::AlibiCatWide, Self::Spline];
    /// The thesis', in Table 3.1's order; its ALiBi-Cat may be of either width.
    pub const THESIS: [Self; 3] = [Self::Alibi, Self::AlibiCat, Self::Spline];

    /// Returns its name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Spline => "spline",
            Self::Alibi => "alibi",
            Self::AlibiCat => "alibi-cat",
            Self::AlibiCatWide => "alibi-cat-wide",
        }
    }

    /// Returns its name in the thesis' tables.
    pub fn title(self) -> &'static str {
        match self {
            Self::Spline => "Spline",
            Self::Alibi => "ALiBi",
            Self::AlibiCat => "ALiBi-Cat",
            Self::AlibiCatWide => "ALiBi-Cat, decoder of 2c",
        }
    }

    /// Returns how many numbers it keeps of a sequence, for control points of `latent` numbers.
    pub fn numbers(self, latent: usize) -> usize {
        self.tokens().control_points() * latent
    }

    /// Returns the kind of the decoder's tokens.
    pub fn tokens(self) -> LatentTokens {
        match self {
            Self::Spline => LatentTokens::Spline(CubicBezier),
            Self::Alibi => LatentTokens::Alibi,
            Self::AlibiCat => LatentTokens::AlibiCat,
            Self::AlibiCatWide => LatentTokens::AlibiCatWide,
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Method {
    type Err = RepresentationError;

    fn from_str(text: &str) -> Result<Self, RepresentationError> {
        let names = Self::ALL.map(Self::name).join(", ");
        let found = Self::ALL.into_iter().find(|method| method.name() == text);
        Ok(found.ok_or_else(|| wrong("method", &format!("one of {names}"), format!("'{text}'")))?)
    }
}

/// Settings of a sequence autoencoder. The crate `lifelike-sequences` has the thesis' for each of its experiments.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SequencePlan {
    /// Seed of weights and batches.
    #[schemars(extend("unit" = "1"))]
    pub seed: u64,
    /// Kind of the decoder's tokens.
    pub method: Method,
    /// Size d of a latent control point.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 4096))]
    pub latent: usize,
    /// Number n of blocks of the encoder, and of the decoder.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 64))]
    pub layers: usize,
    /// Number h of attention heads of a block; a divisor of the width.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 256))]
    pub heads: usize,
    /// Size c of a token.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 4096))]
    pub width: usize,
    /// Inner width of the feed-forward part, as a multiple of `width`.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 16))]
    pub factor: usize,
    /// Sequences per iteration.
    #[schemars(extend("unit" = "sequences"), range(min = 1, max = 1u64 << 16))]
    pub batch: usize,
    /// Sequences that pass through the network at once.
    ///
    /// A batch of 1024 curves at once would need gigabytes. In parts it gives the same gradient up to rounding, which
    /// is why this belongs to the plan.
    #[schemars(extend("unit" = "sequences"), range(min = 1, max = 1u64 << 16))]
    pub part: usize,
    /// Training iterations, over which the learning rate falls to 0 along a cosine.
    ///
    /// The thesis does not give their number.
    #[schemars(extend("unit" = "iterations"), range(min = 1, max = 1u64 << 40))]
    pub iterations: u64,
    /// Optimizer: the thesis' RAdam, Adam, or Muon.
    ///
    /// Adam suits runs of a few hundred iterations, most of which RAdam's own warm-up would take. Muon gets as far as
    /// Adam in about a third of the iterations.
    pub optimizer: Rule,
    /// Largest learning rate.
    #[schemars(extend("unit" = "1"), range(min = 1e-9, max = 10.0))]
    pub learning_rate: f64,
    /// Iterations over which the learning rate rises linearly from 0.
    ///
    /// None in the thesis. Our fix for 3.3.5's collapse.
    #[schemars(extend("unit" = "iterations"))]
    pub warmup: u64,
    /// Norm to which gradients are scaled down; without it they are not clipped, as in the thesis.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "1"), range(min = 1e-9, max = 1e9))]
    pub max_gradient_norm: Option<f64>,
    /// Penalty on control points that come close to each other; none in the thesis.
    ///
    /// Our other fix. Without effect on the baselines, which have one control point.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spread: Option<Spread>,
    /// Iterations between two evaluations of the validation set.
    #[schemars(extend("unit" = "iterations"), range(min = 1, max = 1u64 << 40))]
    pub validate_every: u64,
}

impl Default for SequencePlan {
    fn default() -> Self {
        Self {
            seed: 0,
            method: Method::Spline,
            latent: 16,
            layers: 4,
            heads: 4,
            width: 64,
            factor: 1,
            batch: 256,
            part: 32,
            iterations: 50_000,
            optimizer: Rule::Radam,
            learning_rate: 1e-3,
            warmup: 0,
            max_gradient_norm: None,
            spread: None,
            validate_every: 500,
        }
    }
}

impl SequencePlan {
    /// Checks every range.
    ///
    /// # Errors
    /// The first key out of range.
    pub fn check(&self) -> Result<(), RepresentationError> {
        plan::check("", self)?;
        if !self.width.is_multiple_of(self.heads) {
            return Err(wrong("heads", &format!("a divisor of the width {}", self.width), self.heads).into());
        }
        Ok(whole("warmup", self.warmup, 0, self.iterations)?)
    }

    /// Returns the learning rate at an iteration (counted from 0): a cosine from the first iteration to the last
    /// (Loshchilov & Hutter 2017), times the warm-up.
    pub fn learning_rate_at(&self, iteration: u64) -> f64 {
        let risen = if iteration < self.warmup { (iteration + 1) as f64 / self.warmup as f64 } else { 1.0 };
        self.learning_rate * risen * cosine(iteration, self.iterations, 0.0)
    }

    /// Returns the network for elements of `inputs` numbers.
    pub fn network(&self, inputs: usize) -> AutoencoderConfig {
        let sizes = AutoencoderConfig::new(inputs, self.latent, self.layers, self.heads, self.width);
        AutoencoderConfig { factor: self.factor, ..sizes }.with_tokens(self.method.tokens())
    }

    /// Returns the optimizer's constants.
    pub fn adam(&self) -> AdamConfig {
        AdamConfig { rule: self.optimizer, ..AdamConfig::adam() }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_plan_survives_toml() {
        let plan = SequencePlan {
            max_gradient_norm: Some(1.5),
            spread: Some(Spread { weight: 0.1, floor: 0.5 }),
            method: Method::AlibiCat,
            ..SequencePlan::default()
        };
        for plan in [plan, SequencePlan::default()] {
            assert_eq!(toml::from_str::<SequencePlan>(&toml::to_string(&plan).unwrap()).unwrap(), plan);
        }
        assert_eq!(toml::from_str::<SequencePlan>("").unwrap(), SequencePlan::default());
    }

    #[test]
    fn what_is_wrong_is_named_with_what_is_right() {
        let error = |text: &str| toml::from_str::<SequencePlan>(text).unwrap_err().to_string();
        assert!(error("lattent = 3").contains("unknown field `lattent`"));
        assert!(error("method = 'sine'").contains("`alibi-cat`"));
        let error = |text: &str| toml::from_str::<SequencePlan>(text).unwrap().check().unwrap_err().to_string();
        assert_eq!(error("batch = 0"), "plan: batch: expected 1 to 65536, got 0");
        assert_eq!(error("heads = 3"), "plan: heads: expected a divisor of the width 64, got 3");
        assert_eq!(error("learning_rate = nan"), "plan: learning_rate: expected a number from 1e-9 to 10, got NaN");
        assert_eq!(error("iterations = 10\nwarmup = 11"), "plan: warmup: expected 0 to 10, got 11");
        assert!(error("max_gradient_norm = 0.0").starts_with("plan: max_gradient_norm: expected a number from"));
        let error = "sine".parse::<Method>().unwrap_err().to_string();
        assert!(error.contains("alibi, alibi-cat, alibi-cat-wide, spline") && error.contains("'sine'"), "{error}");
    }

    #[test]
    fn the_rate_rises_over_the_warm_up_and_falls_along_a_cosine() {
        let plan = SequencePlan { learning_rate: 2.0, iterations: 100, ..SequencePlan::default() };
        assert_eq!(plan.learning_rate_at(0), 2.0);
        assert!((plan.learning_rate_at(50) - 1.0).abs() < 1e-12 && plan.learning_rate_at(100) < 1e-12);
        let warm = SequencePlan { warmup: 10, ..plan.clone() };
        assert_eq!(warm.learning_rate_at(0), 0.2);
        assert!(warm.learning_rate_at(8) < plan.learning_rate_at(8));
        assert_eq!(warm.learning_rate_at(10), plan.learning_rate_at(10));
    }
}
