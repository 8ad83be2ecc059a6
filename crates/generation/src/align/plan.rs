//! Settings of an alignment, a TOML file.

use std::path::PathBuf;

use lifelike_train::plan;

use super::JudgePlan;
use crate::GenerationError;
use crate::generator::GeneratorHeader;
use crate::training::GeneratorPlan;

/// An alignment of a generator (thesis Table 5.1). The network is the generator's.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AlignPlan {
    /// Robot: a built-in name, or an MJCF or URDF file.
    pub robot: String,
    /// Generator to begin with.
    pub generator: PathBuf,
    /// Critic, frozen.
    pub critic: PathBuf,
    /// Captioned motion of the generator's own loss L_MDM, as in a generator's plan.
    pub clips: Vec<PathBuf>,
    /// Seed of everything random.
    #[serde(default)]
    #[schemars(extend("unit" = "1"))]
    pub seed: u64,
    /// Weight β of the critic's values (eq. 5.7).
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1e3))]
    pub beta: f64,
    /// Motions per iteration.
    #[schemars(extend("unit" = "motions"), range(min = 1, max = 1u64 << 16))]
    pub batch: usize,
    /// Motions that pass through the network at once on one core.
    #[schemars(extend("unit" = "motions"), range(min = 1, max = 1u64 << 16))]
    pub part: usize,
    /// Training iterations.
    #[schemars(extend("unit" = "iterations"), range(min = 1, max = 1u64 << 40))]
    pub iterations: u64,
    /// Wall time after which the training ends; none: only the iterations count (min).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "min"), range(min = 0.01, max = 1e6))]
    pub minutes: Option<f64>,
    /// Learning rate η_f of Adam.
    #[schemars(extend("unit" = "1"), range(min = 1e-9, max = 10.0))]
    pub learning_rate: f64,
    /// Iterations over which the learning rate rises linearly from 0.
    #[schemars(extend("unit" = "iterations"), range(min = 0, max = 1u64 << 40))]
    pub warmup: u64,
    /// Norm to which gradients are scaled down.
    #[schemars(extend("unit" = "1"), range(min = 1e-9, max = 1e9))]
    pub max_gradient_norm: f64,
    /// Decay of the weights' moving average.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1.0))]
    pub ema: f64,
    /// Share of motions that are shown without their caption.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1.0))]
    pub condition_dropout: f64,
    /// Iterations between two validations and checkpoints.
    #[schemars(extend("unit" = "iterations"), range(min = 1, max = 1u64 << 40))]
    pub validate_every: u64,
    /// Largest relative rise of the loss on held-out motion, at which the alignment stops.
    ///
    /// The best weights within it are the result.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1e3))]
    pub tolerance: f64,
    /// Number of training prompts on which Realism is measured.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 10_000))]
    pub prompts: usize,
    /// Policy that chooses the best weights in physics at every validation; none: the critic's Realism chooses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub policy: Option<PathBuf>,
    /// Motion that this policy executes.
    #[serde(default)]
    pub judge: JudgePlan,
}

impl AlignPlan {
    /// Returns the training of a generator that this is, and checks every range.
    ///
    /// # Errors
    /// The first key out of range.
    pub fn training(&self, generator: &GeneratorHeader) -> Result<GeneratorPlan, GenerationError> {
        plan::check("", self)?;
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
