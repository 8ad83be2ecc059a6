//! Settings of a generator and of its training, a TOML file.

use std::path::PathBuf;

use lifelike_nn::schedules::cosine;
use lifelike_nn::transformer::encoder::EncoderSizes;
use lifelike_train::limits::{range, whole, wrong};

use crate::GenerationError;
use crate::space::SpaceKind;

/// A training of a generator. The defaults train within an hour on two cores on 8 h of motion.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GeneratorPlan {
    /// A built-in robot's name, or its MJCF or URDF file.
    pub robot: String,
    /// Captioned motion: folders with a `dataset.jsonl`; clips without one are captioned by their container, or their
    /// name.
    pub clips: Vec<PathBuf>,
    /// Key of all randomness.
    pub seed: u64,
    /// Kind of the tokens.
    pub space: SpaceKind,
    /// Motion beyond this is cut off (s).
    pub max_seconds: f64,
    /// D: diffusion steps.
    pub diffusion_steps: usize,
    /// c: numbers of a token.
    pub width: usize,
    /// Layers.
    pub layers: usize,
    /// Heads of a layer.
    pub heads: usize,
    /// Inner width of the feed-forward part.
    pub inner: usize,
    /// Most word pieces that are learned on the captions.
    pub pieces: usize,
    /// True if the network sees how long the motion is.
    pub duration: bool,
    /// Weight of the joints' velocities in the loss of [`SpaceKind::Spline`] (rows hold them already): squared errors
    /// of differences of neighbouring control points, each in that difference's own variance. A limb that swings fast
    /// and little (a hand that waves) counts as much as its place.
    pub velocity_weight: f64,
    /// Share of motions that are shown without their caption, for classifier-free guidance.
    pub condition_dropout: f64,
    /// Motions of one iteration.
    pub batch: usize,
    /// Motions that pass through the network at once on one core. In parts of another size gradients are the same up to
    /// rounding, which is why this belongs to the plan.
    pub part: usize,
    /// Iterations.
    pub iterations: u64,
    /// Wall time after which the training ends (minutes); none: only the iterations count.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub minutes: Option<f64>,
    /// The largest learning rate.
    pub learning_rate: f64,
    /// Iterations over which the learning rate rises linearly from 0.
    pub warmup: u64,
    /// Share of the learning rate that is left at the end of a cosine; 1 keeps it constant.
    pub final_learning_rate: f64,
    /// Gradients are scaled down to this norm.
    pub max_gradient_norm: f64,
    /// Rate of the weights' moving average.
    pub ema: f64,
    /// Iterations between two validations and checkpoints.
    pub validate_every: u64,
}

impl Default for GeneratorPlan {
    fn default() -> Self {
        Self {
            robot: "lima".into(),
            clips: Vec::new(),
            seed: 0,
            space: SpaceKind::default(),
            max_seconds: 10.0,
            diffusion_steps: 50,
            width: 128,
            layers: 4,
            heads: 4,
            inner: 512,
            pieces: 1024,
            duration: true,
            velocity_weight: 1.0,
            condition_dropout: 0.1,
            batch: 64,
            part: 8,
            iterations: 10_000,
            minutes: None,
            learning_rate: 5e-4,
            warmup: 500,
            final_learning_rate: 0.05,
            max_gradient_norm: 1.0,
            ema: 0.9999,
            validate_every: 500,
        }
    }
}

impl GeneratorPlan {
    /// Checks every range.
    ///
    /// # Errors
    /// The first key out of range.
    pub fn check(&self) -> Result<(), GenerationError> {
        if let SpaceKind::Spline { knot_seconds } = self.space {
            range("space.knot_seconds", knot_seconds, 0.05, 2.0)?;
        }
        range("max_seconds", self.max_seconds, 0.5, 60.0)?;
        whole("diffusion_steps", self.diffusion_steps as u64, 2, 10_000)?;
        whole("width", self.width as u64, 2, 4096)?;
        whole("layers", self.layers as u64, 1, 64)?;
        whole("heads", self.heads as u64, 1, 256)?;
        if !self.width.is_multiple_of(self.heads) || !self.width.is_multiple_of(2) {
            let expected = format!("a divisor of the width {}, which is even", self.width);
            return Err(wrong("heads", &expected, self.heads).into());
        }
        whole("inner", self.inner as u64, 1, 1 << 16)?;
        whole("pieces", self.pieces as u64, 100, 1 << 20)?;
        range("velocity_weight", self.velocity_weight, 0.0, 1e6)?;
        range("condition_dropout", self.condition_dropout, 0.0, 1.0)?;
        whole("batch", self.batch as u64, 1, 1 << 16)?;
        whole("part", self.part as u64, 1, 1 << 16)?;
        whole("iterations", self.iterations, 1, 1 << 40)?;
        if let Some(minutes) = self.minutes {
            range("minutes", minutes, 0.01, 1e6)?;
        }
        range("learning_rate", self.learning_rate, 1e-9, 10.0)?;
        whole("warmup", self.warmup, 0, 1 << 40)?;
        range("final_learning_rate", self.final_learning_rate, 0.0, 1.0)?;
        range("max_gradient_norm", self.max_gradient_norm, 1e-9, 1e9)?;
        range("ema", self.ema, 0.0, 1.0)?;
        Ok(whole("validate_every", self.validate_every, 1, 1 << 40)?)
    }

    /// Returns the transformer's sizes.
    pub fn encoder(&self) -> EncoderSizes {
        EncoderSizes { width: self.width, layers: self.layers, heads: self.heads, inner: self.inner }
    }

    /// Returns the learning rate at an iteration (counted from 0).
    pub fn learning_rate_at(&self, iteration: u64) -> f64 {
        let risen = if iteration < self.warmup { (iteration + 1) as f64 / self.warmup as f64 } else { 1.0 };
        self.learning_rate * risen * cosine(iteration, self.iterations, self.final_learning_rate)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn plans_survive_toml_and_say_what_is_wrong() {
        for space in [SpaceKind::Frames, SpaceKind::default()] {
            let plan = GeneratorPlan { space, minutes: Some(3.0), ..GeneratorPlan::default() };
            assert_eq!(toml::from_str::<GeneratorPlan>(&toml::to_string(&plan).unwrap()).unwrap(), plan);
        }
        let plan = |text: &str| toml::from_str::<GeneratorPlan>(text);
        assert!(plan("").unwrap().check().is_ok());
        assert!(plan("witdh = 3").unwrap_err().to_string().contains("unknown field `witdh`"));
        assert!(plan("space = { kind = 'bezier' }").unwrap_err().to_string().contains("bezier"));
        let error = |text: &str| plan(text).unwrap().check().unwrap_err().to_string();
        assert_eq!(error("batch = 0"), "plan: batch: expected 1 to 65536, got 0");
        assert_eq!(error("heads = 3"), "plan: heads: expected a divisor of the width 128, which is even, got 3");
        assert!(error("space = { kind = 'spline', knot_seconds = 0.0 }").contains("space.knot_seconds"));
        assert!(error("ema = nan").contains("plan: ema"));
    }
}
