//! The plan of a critic.

use lifelike_train::gae::Discounts;
use lifelike_train::plan;

use super::file::MAX_MEMBERS;
use crate::GenerationError;
use crate::representation::RepresentationSpec;

/// Settings of a critic and its training (thesis Table 5.1).
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CriticPlan {
    /// Motion that the critic sees on either side of t; 0: the row at t alone (s).
    #[schemars(extend("unit" = "s"), range(min = 0.0, max = 10.0))]
    pub window: f64,
    /// Number of networks, whose least value counts.
    ///
    /// Each has first weights and a bootstrap sample of the clips of its own.
    #[schemars(extend("unit" = "1"), range(min = 1, max = MAX_MEMBERS))]
    pub members: usize,
    /// Widths of the hidden layers, ELU between them.
    #[schemars(extend("unit" = "1"), inner(range(min = 1, max = 4096)))]
    pub hidden: Vec<usize>,
    /// Discount γ of a control step.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 0.9999))]
    pub gamma: f64,
    /// λ of the targets (eq. 5.3).
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1.0))]
    pub lambda: f64,
    /// Targets continue across jumps to another clip, as the thesis' expectation over future references does.
    pub across_jumps: bool,
    /// Learning rate η_c of Adam.
    #[schemars(extend("unit" = "1"), range(min = 1e-8, max = 1.0))]
    pub learning_rate: f64,
    /// Decay of the weights in each step, as a share of the learning rate (AdamW, Loshchilov & Hutter 2019).
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 10.0))]
    pub weight_decay: f64,
    /// Epochs over all records; the targets are computed anew before each.
    #[schemars(extend("unit" = "epochs"), range(min = 1, max = 1_000_000))]
    pub epochs: u64,
    /// Windows of a gradient step.
    #[schemars(extend("unit" = "windows"), range(min = 1, max = 1u64 << 20))]
    pub minibatch: usize,
    /// Share of the clips that is held out; the network that is best on them is the result.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 0.9))]
    pub validation: f64,
    /// Epochs between validations and checkpoints.
    #[schemars(extend("unit" = "epochs"), range(min = 1, max = 1_000_000))]
    pub validate_every: u64,
}

impl Default for CriticPlan {
    fn default() -> Self {
        Self {
            window: 0.3,
            members: 3,
            hidden: vec![256; 3],
            gamma: 0.9,
            lambda: 0.95,
            across_jumps: true,
            learning_rate: 3e-4,
            weight_decay: 0.01,
            epochs: 60,
            minibatch: 512,
            validation: 0.1,
            validate_every: 2,
        }
    }
}

impl CriticPlan {
    /// Checks that every value is in its range.
    ///
    /// # Errors
    /// [`GenerationError::Plan`] with the key, the range and the value.
    pub fn check(&self) -> Result<(), GenerationError> {
        Ok(plan::check("critic", self)?)
    }

    /// Returns the discounts of the targets.
    pub fn discounts(&self) -> Discounts {
        Discounts { gamma: self.gamma as f32, lambda: self.lambda as f32 }
    }

    /// Returns the rows of a window on either side of t.
    pub fn radius(&self, spec: &RepresentationSpec) -> usize {
        (self.window * spec.fps).round() as usize
    }
}
