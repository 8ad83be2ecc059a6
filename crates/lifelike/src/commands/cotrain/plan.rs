//! Settings of a co-training, a TOML file.

use std::path::PathBuf;

use lifelike_generation::align::JudgePlan;
use lifelike_language::Split;
use lifelike_train::plan;
use serde::{Deserialize, Serialize};

use crate::error::CliError;

/// A co-training.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CotrainPlan {
    /// Robot: a built-in name, or an MJCF or URDF file.
    pub robot: String,
    /// Generator to begin with.
    pub generator: PathBuf,
    /// Tracker to begin with: a name, its run, or its controller.
    pub init: PathBuf,
    /// Captioned motion that the generator was trained on.
    pub dataset: PathBuf,
    /// Clips that the tracker learns besides.
    pub clips: Vec<PathBuf>,
    /// Seed of everything random.
    #[schemars(extend("unit" = "1"))]
    pub seed: u64,
    /// Number of rounds.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 1000))]
    pub rounds: usize,
    /// Number of training sentences whose motion tracker and critic learn from.
    ///
    /// They learn from the motion of all rounds so far. A critic that saw only what the last alignment liked would
    /// praise again what the one before it unlearned.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 100_000))]
    pub prompts: usize,
    /// Number of sentences on which each round is measured.
    #[schemars(extend("unit" = "1"), range(min = 1, max = 100_000))]
    pub measured: usize,
    /// Split of these sentences.
    pub split: Split,
    /// Motion that chooses the weights within a round and the best round, in physics.
    #[serde(default)]
    pub judge: JudgePlan,
    /// Training of the tracker; none: it stays as it is, and only generator and critic learn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tracker: Option<StagePlan>,
    /// Training of the critic.
    pub critic: StagePlan,
    /// Alignment of the generator.
    pub align: StagePlan,
}

/// One training of each round.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StagePlan {
    /// Plan: a built-in name, or a file.
    pub plan: PathBuf,
    /// Changes to it, `key=value`.
    #[serde(default)]
    pub keys: Vec<String>,
}

impl CotrainPlan {
    /// Checks every range.
    pub fn check(&self) -> Result<(), CliError> {
        Ok(plan::check("", self)?)
    }
}
