//! Settings of a co-training, a TOML file.

use std::path::PathBuf;

use lifelike_generation::align::JudgePlan;
use lifelike_language::Split;
use lifelike_train::limits::whole;
use serde::{Deserialize, Serialize};

use crate::error::CliError;

/// A co-training.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CotrainPlan {
    /// A built-in robot's name, or its MJCF or URDF file.
    pub robot: String,
    /// The generator to begin with.
    pub generator: PathBuf,
    /// The tracker to begin with: a name, its run, or its controller.
    pub init: PathBuf,
    /// Captioned motion that the generator was trained on.
    pub dataset: PathBuf,
    /// The tracker's own clips.
    pub clips: Vec<PathBuf>,
    /// Key of all randomness.
    pub seed: u64,
    /// Rounds.
    pub rounds: usize,
    /// Sentences of the training split whose motion tracker and critic learn from. They learn from the motion of all
    /// rounds so far: a critic that saw only what the last alignment liked praises again what the one before it unlearned.
    pub prompts: usize,
    /// Sentences that is measured on.
    pub measured: usize,
    /// Their split.
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StagePlan {
    /// A built-in plan's name, or a file.
    pub plan: PathBuf,
    /// Changes to it, `key=value`.
    #[serde(default)]
    pub keys: Vec<String>,
}

impl CotrainPlan {
    /// Checks every range.
    pub fn check(&self) -> Result<(), CliError> {
        self.judge.check()?;
        whole("rounds", self.rounds as u64, 1, 1000)?;
        whole("prompts", self.prompts as u64, 1, 100_000)?;
        Ok(whole("measured", self.measured as u64, 1, 100_000)?)
    }
}
