//! Settings of an alignment, a TOML file.

use std::path::PathBuf;

use lifelike_train::limits::{range, whole};

use super::JudgePlan;
use crate::GenerationError;
use crate::generator::GeneratorHeader;
use crate::training::GeneratorPlan;

/// An alignment of a generator (thesis Table 5.1). The network is the generator's.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AlignPlan {
    /// A built-in robot's name, or its MJCF or URDF file.
    pub robot: String,
    /// The generator to begin with.
    pub generator: PathBuf,
    /// The critic, frozen.
    pub critic: PathBuf,
    /// Captioned motion for L_MDM, as in a generator's plan.
    pub clips: Vec<PathBuf>,
    /// Key of all randomness.
    #[serde(default)]
    pub seed: u64,
    /// β of eq. 5.7.
    pub beta: f64,
    /// Motions of one iteration.
    pub batch: usize,
    /// Motions that pass through the network at once on one core.
    pub part: usize,
    /// Iterations.
    pub iterations: u64,
    /// Wall time after which it ends (minutes); none: only the iterations count.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub minutes: Option<f64>,
    /// Learning rate η_f of Adam.
    pub learning_rate: f64,
    /// Iterations over which the learning rate rises linearly from 0.
    pub warmup: u64,
    /// Gradients are scaled down to this norm.
    pub max_gradient_norm: f64,
    /// Rate of the weights' moving average.
    pub ema: f64,
    /// Share of motions that are shown without their caption.
    pub condition_dropout: f64,
    /// Iterations between two validations and checkpoints.
    pub validate_every: u64,
    /// The guard: greatest rise of the loss on motion that is not trained on, as a share of what it was. Beyond it the
    /// alignment stops, and the best weights within it are the result.
    pub tolerance: f64,
    /// Prompts of the training set that Realism is measured on.
    pub prompts: usize,
    /// Policy that chooses the best weights in physics at every validation; none: the critic's Realism chooses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub policy: Option<PathBuf>,
    /// Motion that it plays.
    #[serde(default)]
    pub judge: JudgePlan,
}

impl AlignPlan {
    /// Returns the training of a generator that this is, and checks every range.
    ///
    /// # Errors
    /// The first key out of range.
    pub fn training(&self, generator: &GeneratorHeader) -> Result<GeneratorPlan, GenerationError> {
        range("beta", self.beta, 0.0, 1e3)?;
        range("tolerance", self.tolerance, 0.0, 1e3)?;
        whole("prompts", self.prompts as u64, 1, 10_000)?;
        self.judge.check()?;
        let encoder = generator.sizes.encoder;
        let plan = GeneratorPlan {
            robot: self.robot.clone(),
            clips: self.clips.clone(),
            seed: self.seed,
            space: generator.space,
            max_seconds: generator.max_seconds,
            diffusion_steps: generator.diffusion_steps,
            width: encoder.width,
            layers: encoder.layers,
            heads: encoder.heads,
            inner: encoder.inner,
            duration: generator.sizes.duration,
            condition_dropout: self.condition_dropout,
            batch: self.batch,
            part: self.part,
            iterations: self.iterations,
            minutes: self.minutes,
            learning_rate: self.learning_rate,
            warmup: self.warmup,
            final_learning_rate: 1.0,
            max_gradient_norm: self.max_gradient_norm,
            ema: self.ema,
            validate_every: self.validate_every,
            ..GeneratorPlan::default()
        };
        plan.check()?;
        Ok(plan)
    }
}
