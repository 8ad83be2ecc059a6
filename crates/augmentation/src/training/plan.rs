//! Settings of an augmentation's training.

use lifelike_nn::schedules::cosine;
use lifelike_train::limits::wrong;
use lifelike_train::plan;

use crate::AugmentationError;
use crate::augmentation::Feedback;
use crate::loss::LossKind;
use crate::model::{Frame, SatSizes};

/// Errors before that training shows to the encoder.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FeedbackShares {
    /// Share of the stretches with the measured errors (teacher forcing).
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1.0))]
    pub measured: f64,
    /// Share of the stretches with the network's own predictions, step after step (closed loop).
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1.0))]
    pub predicted: f64,
    /// Share of the iterations over which closed-loop steps change from measured errors to own predictions.
    ///
    /// Scheduled sampling (Bengio et al. 2015): each step gets its own prediction with a probability that rises
    /// linearly, else the measured error. 0: predictions from the first iteration on.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1.0))]
    pub ramp: f64,
}

impl Default for FeedbackShares {
    fn default() -> Self {
        Self { measured: 0.25, predicted: 0.25, ramp: 0.5 }
    }
}

impl FeedbackShares {
    /// The thesis' encoder always gets an error, measured or its own (2.4): half of the stretches each.
    pub const THESIS: Self = Self { measured: 0.5, predicted: 0.5, ramp: 0.5 };

    /// Returns the probability that a closed-loop step gets its own prediction.
    pub fn own_at(self, iteration: u64, iterations: u64) -> f64 {
        let risen = self.ramp * iterations as f64;
        if risen > 0.0 { (iteration as f64 / risen).min(1.0) } else { 1.0 }
    }

    /// Returns the feedback that validation uses: nothing where some stretches are trained so, else its own predictions, else
    /// measurements.
    pub fn validated(self) -> Feedback {
        match self.measured + self.predicted < 1.0 {
            true => Feedback::None,
            false if self.predicted > 0.0 => Feedback::Predicted,
            false => Feedback::Measured,
        }
    }
}

/// A training of an augmentation. In the remaining share of the stretches nothing is fed back.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AugmentationPlan {
    /// Seed of everything random.
    #[schemars(extend("unit" = "1"))]
    pub seed: u64,
    /// Class of the building blocks; empty: the first that was measured.
    pub class: String,
    /// Measured columns to predict; empty: all of them.
    pub outputs: Vec<String>,
    /// Names of columns (state, force or reference) that the network is not shown.
    pub leave_out: Vec<String>,
    /// Half widths of the play operators that the network sees: hysteresis; empty: none (rad).
    #[schemars(extend("unit" = "rad"), inner(range(min = 1e-6, max = 1e6)))]
    pub hysteresis: Vec<f64>,
    /// Axes of rigid bodies, world or parent; actuators have none.
    pub frame: Frame,
    /// Network.
    pub model: SatSizes,
    /// Loss.
    pub loss: LossKind,
    /// Weight of the physics-informed term of eq. 2.3.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 1e3))]
    pub physics_weight: f64,
    /// Errors that the encoder sees.
    pub feedback: FeedbackShares,
    /// Steps of a stretch that is learned from at once.
    #[schemars(extend("unit" = "steps"), range(min = 2, max = 1u64 << 20))]
    pub stretch: usize,
    /// Stretches per iteration.
    #[schemars(extend("unit" = "stretches"), range(min = 1, max = 1u64 << 16))]
    pub batch: usize,
    /// Stretches that pass through the network at once on one core.
    #[schemars(extend("unit" = "stretches"), range(min = 1, max = 1u64 << 16))]
    pub part: usize,
    /// Training iterations.
    #[schemars(extend("unit" = "iterations"), range(min = 1, max = 1u64 << 40))]
    pub iterations: u64,
    /// Wall time after which the training ends (min).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("unit" = "min"), range(min = 0.01, max = 1e6))]
    pub minutes: Option<f64>,
    /// Largest learning rate.
    #[schemars(extend("unit" = "1"), range(min = 1e-9, max = 10.0))]
    pub learning_rate: f64,
    /// Iterations over which the learning rate rises from 0.
    #[schemars(extend("unit" = "iterations"), range(min = 0, max = 1u64 << 40))]
    pub warmup: u64,
    /// Decay of the weights in each step, as a share of the learning rate.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 100.0))]
    pub weight_decay: f64,
    /// Standard deviation of noise on the rows, in units of the scales.
    #[schemars(extend("unit" = "1"), range(min = 0.0, max = 10.0))]
    pub noise: f64,
    /// Norm to which gradients are scaled down.
    #[schemars(extend("unit" = "1"), range(min = 1e-9, max = 1e9))]
    pub max_gradient_norm: f64,
    /// Iterations between validations and checkpoints.
    #[schemars(extend("unit" = "iterations"), range(min = 1, max = 1u64 << 40))]
    pub validate_every: u64,
}

impl Default for AugmentationPlan {
    fn default() -> Self {
        Self {
            seed: 0,
            class: String::new(),
            outputs: Vec::new(),
            leave_out: Vec::new(),
            hysteresis: vec![0.003, 0.01, 0.03],
            frame: Frame::Parent,
            model: SatSizes::default(),
            loss: LossKind::Physics,
            physics_weight: 1.0,
            feedback: FeedbackShares::default(),
            stretch: 256,
            batch: 16,
            part: 8,
            iterations: 2000,
            minutes: None,
            learning_rate: 2e-3,
            warmup: 100,
            weight_decay: 0.01,
            noise: 0.02,
            max_gradient_norm: 1.0,
            validate_every: 100,
        }
    }
}

impl AugmentationPlan {
    /// Checks every range.
    ///
    /// # Errors
    /// The first key out of range.
    pub fn check(&self) -> Result<(), AugmentationError> {
        self.model.check()?;
        plan::check("", self)?;
        if self.feedback.measured + self.feedback.predicted > 1.0 {
            let sum = self.feedback.measured + self.feedback.predicted;
            return Err(wrong("feedback", "shares that sum to at most 1", sum).into());
        }
        Ok(())
    }

    /// Returns the learning rate at an iteration (counted from 0).
    pub fn learning_rate_at(&self, iteration: u64) -> f64 {
        let risen = if iteration < self.warmup { (iteration + 1) as f64 / self.warmup as f64 } else { 1.0 };
        self.learning_rate * risen * cosine(iteration, self.iterations, 0.01)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn own_predictions_replace_measured_errors_along_the_ramp() {
        let shares = FeedbackShares::THESIS;
        assert_eq!([0, 25, 50, 99].map(|i| shares.own_at(i, 100)), [0.0, 0.5, 1.0, 1.0]);
        assert_eq!(FeedbackShares { ramp: 0.0, ..shares }.own_at(0, 100), 1.0);
        let forced = FeedbackShares { measured: 1.0, predicted: 0.0, ramp: 0.0 };
        let validated = [FeedbackShares::default(), shares, forced].map(FeedbackShares::validated);
        assert_eq!(validated, [Feedback::None, Feedback::Predicted, Feedback::Measured]);
    }
}
