//! Settings of an augmentation's training.

use lifelike_nn::schedules::cosine;
use lifelike_train::limits::{range, whole, wrong};

use crate::AugmentationError;
use crate::augmentation::Feedback;
use crate::loss::LossKind;
use crate::model::{Frame, SatSizes};

/// Errors before that training shows to the encoder.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FeedbackShares {
    /// Share of the stretches with the measured errors (teacher forcing).
    pub measured: f64,
    /// Share with the network's own predictions, step after step from the stretch's begin (closed loop).
    pub predicted: f64,
    /// Scheduled sampling (Bengio et al. 2015): in these stretches each step gets its own prediction with a probability that rises
    /// linearly over this share of the iterations, else the measured error. 0: predictions from the first iteration on.
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
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AugmentationPlan {
    /// Key of all randomness.
    pub seed: u64,
    /// Class of the building blocks; empty: the first that was measured.
    pub class: String,
    /// Measured columns to predict; empty: all of them.
    pub outputs: Vec<String>,
    /// Names of columns that the network is not shown (`current`), whether state, force or reference.
    pub leave_out: Vec<String>,
    /// Half widths of the play operators that the network is shown of what has a reference (rad): hysteresis. Empty: none.
    pub hysteresis: Vec<f64>,
    /// Axes of rigid bodies, world or parent; actuators have none.
    pub frame: Frame,
    /// The network.
    pub model: SatSizes,
    /// The loss.
    pub loss: LossKind,
    /// Weight of the physics-informed term of eq. 2.3.
    pub physics_weight: f64,
    /// Errors that the encoder sees.
    pub feedback: FeedbackShares,
    /// Steps of a stretch that is learned from at once.
    pub stretch: usize,
    /// Stretches of an iteration.
    pub batch: usize,
    /// Stretches that pass through the network at once on one core.
    pub part: usize,
    /// Iterations.
    pub iterations: u64,
    /// Wall time after which the training ends (minutes).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub minutes: Option<f64>,
    /// The largest learning rate.
    pub learning_rate: f64,
    /// Iterations over which it rises from 0.
    pub warmup: u64,
    /// Decay of the weights in each step, as a share of the learning rate.
    pub weight_decay: f64,
    /// Standard deviation of noise on the rows, in units of the scales.
    pub noise: f64,
    /// Gradients are scaled down to this norm.
    pub max_gradient_norm: f64,
    /// Iterations between validations and checkpoints.
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
        for radius in &self.hysteresis {
            range("hysteresis", *radius, 1e-6, 1e6)?;
        }
        range("physics_weight", self.physics_weight, 0.0, 1e3)?;
        range("feedback.measured", self.feedback.measured, 0.0, 1.0)?;
        range("feedback.predicted", self.feedback.predicted, 0.0, 1.0)?;
        range("feedback.ramp", self.feedback.ramp, 0.0, 1.0)?;
        if self.feedback.measured + self.feedback.predicted > 1.0 {
            let sum = self.feedback.measured + self.feedback.predicted;
            return Err(wrong("feedback", "shares that sum to at most 1", sum).into());
        }
        whole("stretch", self.stretch as u64, 2, 1 << 20)?;
        whole("batch", self.batch as u64, 1, 1 << 16)?;
        whole("part", self.part as u64, 1, 1 << 16)?;
        whole("iterations", self.iterations, 1, 1 << 40)?;
        if let Some(minutes) = self.minutes {
            range("minutes", minutes, 0.01, 1e6)?;
        }
        range("learning_rate", self.learning_rate, 1e-9, 10.0)?;
        whole("warmup", self.warmup, 0, 1 << 40)?;
        range("weight_decay", self.weight_decay, 0.0, 100.0)?;
        range("noise", self.noise, 0.0, 10.0)?;
        range("max_gradient_norm", self.max_gradient_norm, 1e-9, 1e9)?;
        Ok(whole("validate_every", self.validate_every, 1, 1 << 40)?)
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
