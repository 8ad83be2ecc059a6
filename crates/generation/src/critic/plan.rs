//! The plan of a critic.

use lifelike_train::gae::Discounts;
use lifelike_train::limits::{range, whole};

use super::file::MAX_MEMBERS;
use crate::GenerationError;
use crate::representation::RepresentationSpec;

/// Settings of a critic and its training (thesis Table 5.1).
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CriticPlan {
    /// Motion that the critic sees on either side of t (s); 0: the row at t alone.
    pub window: f64,
    /// Networks, each with first weights and a bootstrap sample of the clips of its own; the value is their least.
    pub members: usize,
    /// Hidden layers, ELU between them.
    pub hidden: Vec<usize>,
    /// Discount γ of a control step.
    pub gamma: f64,
    /// λ of the targets (eq. 5.3).
    pub lambda: f64,
    /// Targets go on across jumps to another clip, as the thesis' expectation over future references does.
    pub across_jumps: bool,
    /// Learning rate η_c of Adam.
    pub learning_rate: f64,
    /// Decay of the weights in each step, as a share of the learning rate (AdamW, Loshchilov & Hutter 2019).
    pub weight_decay: f64,
    /// Epochs over all records; the targets are computed anew before each.
    pub epochs: u64,
    /// Windows of a gradient step.
    pub minibatch: usize,
    /// Share of the clips that is not learned from: the best network on them is the result.
    pub validation: f64,
    /// Epochs between validations and checkpoints.
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
        range("critic.window", self.window, 0.0, 10.0)?;
        whole("critic.members", self.members as u64, 1, MAX_MEMBERS as u64)?;
        for width in &self.hidden {
            whole("critic.hidden", *width as u64, 1, 4096)?;
        }
        range("critic.gamma", self.gamma, 0.0, 0.9999)?;
        range("critic.lambda", self.lambda, 0.0, 1.0)?;
        range("critic.learning_rate", self.learning_rate, 1e-8, 1.0)?;
        range("critic.weight_decay", self.weight_decay, 0.0, 10.0)?;
        whole("critic.epochs", self.epochs, 1, 1_000_000)?;
        whole("critic.minibatch", self.minibatch as u64, 1, 1 << 20)?;
        range("critic.validation", self.validation, 0.0, 0.9)?;
        Ok(whole("critic.validate_every", self.validate_every, 1, 1_000_000)?)
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
