//! The core of every supervised training: moments, counters, averages and the best parameters of one network.
//!
//! A trainer computes loss and gradient; [`SupervisedCore::step`] does the rest. A gradient that is not finite changes
//! neither parameters nor moments nor averages: it is skipped, counted, logged, and reported on standard error.

use std::ops::Range;
use std::sync::Arc;

use lifelike_checkpoint::{Checkpoint, CheckpointError};
use lifelike_dense::norm;
use lifelike_nn::adam::{Adam, AdamConfig, Descent};
use lifelike_nn::parameters::Parameters;
use lifelike_nn::rows::Layout;
use lifelike_simd::InstructionSet;

use crate::task::Scalar;

/// Metrics of one step that every supervised training has. All of it is determined by plan and data.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct StepMetrics {
    /// Iterations done, this one included.
    pub iteration: u64,
    /// Minimized loss, before the step.
    pub loss: f64,
    /// Learning rate of this iteration.
    pub learning_rate: f64,
    /// Norm of the gradient before clipping.
    pub gradient_norm: f64,
    /// Iterations so far whose gradient was not finite and was skipped.
    pub skipped: u64,
}

impl StepMetrics {
    /// Returns the numbers to log, the loss as `Loss/training`. A number that is not finite is left out.
    pub fn scalars(&self) -> Vec<Scalar> {
        self.scalars_with(&[])
    }

    /// Returns the numbers to log, with those that only this training has.
    pub fn scalars_with(&self, own: &[(&str, f64)]) -> Vec<Scalar> {
        [
            ("Loss/training", self.loss),
            ("Schedule/learning_rate", self.learning_rate),
            ("Gradient/norm", self.gradient_norm),
            ("Gradient/skipped", self.skipped as f64),
        ]
        .iter()
        .chain(own)
        .filter(|(_, value)| value.is_finite())
        .map(|(name, value)| (name.to_string(), *value))
        .collect()
    }
}

/// Weight decay apart from the gradient (AdamW): parameters are multiplied before the step.
#[derive(Debug, Clone, Copy)]
pub struct Decay<'a> {
    /// Decay for a learning rate of one.
    pub weight: f64,
    /// The parameters that decay.
    pub ranges: &'a [Range<usize>],
}

impl Decay<'_> {
    /// No decay.
    pub const NONE: Self = Self { weight: 0.0, ranges: &[] };
}

/// Everything that a training keeps of one network between two steps, apart from its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct SupervisedCore {
    optimizer: Adam,
    iteration: u64,
    skipped: u64,
    average: Option<Average>,
    best: Option<(f64, Vec<f32>)>,
}

impl SupervisedCore {
    /// Returns the core of a training of `count` parameters that has not begun.
    pub fn new(config: AdamConfig, count: usize) -> Self {
        Self { optimizer: Adam::new(config, count), iteration: 0, skipped: 0, average: None, best: None }
    }

    /// Also averages the parameters, which begin with `values`; see [`Average`].
    #[must_use]
    pub fn with_average(self, rate: f64, values: Vec<f32>) -> Self {
        Self { average: Some(Average { rate, values }), ..self }
    }

    /// Returns the iterations done.
    pub fn iteration(&self) -> u64 {
        self.iteration
    }

    /// Returns the iterations whose gradient was skipped.
    pub fn skipped(&self) -> u64 {
        self.skipped
    }

    /// Returns the averaged parameters, where the training has an average.
    pub fn average(&self) -> Option<&[f32]> {
        self.average.as_ref().map(|average| average.values.as_slice())
    }

    /// Returns the parameters of the best validation, where there was one.
    pub fn best(&self) -> Option<&[f32]> {
        self.best.as_ref().map(|(_, values)| values.as_slice())
    }

    /// Remembers the parameters if no validation scored as high; higher is better.
    pub fn validated(&mut self, score: f64, values: &[f32]) {
        if self.best.as_ref().is_none_or(|(best, _)| score > *best) {
            self.best = Some((score, values.to_vec()));
        }
    }

    /// Takes one step against the gradient of a loss.
    ///
    /// # Panics
    /// As [`Adam::step`].
    pub fn step(
        &mut self,
        layout: &Layout,
        values: &mut [f32],
        loss: f64,
        descent: Descent<'_>,
        decay: Decay<'_>,
    ) -> StepMetrics {
        if decay.weight != 0.0 && norm(InstructionSet::chosen(), descent.gradient).is_finite() {
            let keep = 1.0 - (descent.rate * decay.weight) as f32;
            for range in decay.ranges {
                values[range.clone()].iter_mut().for_each(|x| *x *= keep);
            }
        }
        let stepped = self.optimizer.step(layout, values, descent);
        if stepped.taken {
            if let Some(average) = &mut self.average {
                average.add(values, self.iteration);
            }
        } else {
            self.skipped += 1;
            let (iteration, skipped) = (self.iteration, self.skipped);
            tracing::warn!("iteration {iteration}: the gradient is not finite, skipped; {skipped} so far");
        }
        self.iteration += 1;
        StepMetrics {
            iteration: self.iteration,
            loss,
            learning_rate: descent.rate,
            gradient_norm: stepped.norm,
            skipped: self.skipped,
        }
    }

    /// Takes a step of parameters without decay.
    ///
    /// # Panics
    /// As [`Adam::step`].
    pub fn step_of(&mut self, parameters: &mut Parameters, loss: f64, descent: Descent<'_>) -> StepMetrics {
        let layout = Arc::clone(parameters.layout());
        self.step(&layout, parameters.values_mut(), loss, descent, Decay::NONE)
    }

    /// Writes everything under `prefix`, exact bits, moments by the parameters' names.
    ///
    /// # Errors
    /// A name is taken.
    pub fn save_into(&self, layout: &Layout, file: &mut Checkpoint, prefix: &str) -> Result<(), CheckpointError> {
        file.put_u64(&format!("{prefix}.progress"), &[2], vec![self.iteration, self.skipped])?;
        self.optimizer.save_into(layout, file, &format!("{prefix}.moments"))?;
        if let Some(average) = &self.average {
            layout.save_into(file, &format!("{prefix}.average"), &average.values)?;
        }
        if let Some((score, values)) = &self.best {
            file.put_f64(&format!("{prefix}.best_score"), &[1], vec![*score])?;
            layout.save_into(file, &format!("{prefix}.best"), values)?;
        }
        Ok(())
    }

    /// Continues with what was saved under `prefix`.
    ///
    /// # Errors
    /// Arrays that are missing, or of another size than the parameters.
    pub fn load_from(&mut self, layout: &Layout, file: &Checkpoint, prefix: &str) -> Result<(), CheckpointError> {
        let progress = file.u64s(&format!("{prefix}.progress"), &[2])?;
        let optimizer = Adam::load_from(self.optimizer.config(), layout, file, &format!("{prefix}.moments"))?;
        let average = match &self.average {
            Some(Average { rate, .. }) => {
                Some(Average { rate: *rate, values: layout.load_from(file, &format!("{prefix}.average"))? })
            }
            None => None,
        };
        let score = format!("{prefix}.best_score");
        let best = match file.contains(&score) {
            true => Some((file.f64s(&score, &[1])?[0], layout.load_from(file, &format!("{prefix}.best"))?)),
            false => None,
        };
        *self = Self { optimizer, iteration: progress[0], skipped: progress[1], average, best };
        Ok(())
    }
}

/// The mean of all parameters so far, the last ones counting most: mean ← r mean + (1 − r) parameters.
///
/// r is the rate, but at most (1 + n) / (10 + n) at step n: a short training is not averaged with its beginning.
#[derive(Debug, Clone, PartialEq)]
struct Average {
    rate: f64,
    values: Vec<f32>,
}

impl Average {
    /// Adds the parameters after step n, counted from 0.
    fn add(&mut self, parameters: &[f32], n: u64) {
        let rate = self.rate.min((1.0 + n as f64) / (10.0 + n as f64));
        let share = (1.0 - rate) as f32;
        self.values.iter_mut().zip(parameters).for_each(|(mean, x)| *mean += share * (x - *mean));
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn layout() -> Layout {
        Layout::of_shapes(vec![("a".into(), vec![2]), ("b".into(), vec![1])])
    }

    fn descent(gradient: &[f32]) -> Descent<'_> {
        Descent { gradient, max_norm: f64::INFINITY, rate: 0.1 }
    }

    #[test]
    fn a_gradient_that_is_not_finite_changes_nothing_and_is_counted() {
        let (layout, mut values) = (layout(), vec![1.0_f32, 2.0, 3.0]);
        let mut core = SupervisedCore::new(AdamConfig::adam(), 3).with_average(0.9, values.clone());
        let first_two = 0..2;
        let decay = Decay { weight: 0.5, ranges: &[first_two] };
        core.step(&layout, &mut values, 1.0, descent(&[0.1, 0.2, 0.3]), decay);
        let (before, known) = (core.clone(), values.clone());
        for wrong in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let metrics = core.step(&layout, &mut values, f64::NAN, descent(&[0.1, wrong, 0.3]), decay);
            assert_eq!(metrics.scalars().len(), 2, "no loss and no norm: {metrics:?}");
        }
        assert_eq!(values, known);
        assert_eq!((core.iteration(), core.skipped()), (4, 3));
        assert_eq!((&core.optimizer, &core.average), (&before.optimizer, &before.average));
    }

    #[test]
    fn weights_decay_before_the_step_by_hand() {
        let (layout, mut values) = (layout(), vec![1.0_f32, 1.0, 1.0]);
        let mut core = SupervisedCore::new(AdamConfig::adam(), 3);
        let first = 0..1;
        let decay = Decay { weight: 0.5, ranges: &[first] };
        core.step(&layout, &mut values, 0.0, descent(&[1.0, 1.0, 1.0]), decay);
        // Adam's first step is the learning rate; 1 - 0.1 · 0.5 is left of what decays.
        for (value, expected) in values.iter().zip([0.95 - 0.1, 0.9, 0.9]) {
            assert!((value - expected).abs() < 1e-6, "{values:?}");
        }
    }

    #[test]
    fn an_average_forgets_at_its_rate_once_it_has_begun() {
        let mut average = Average { rate: 0.5, values: vec![0.0] };
        average.add(&[1.0], 0);
        assert!((average.values[0] - 0.9).abs() < 1e-6, "the first step counts 0.9: {average:?}");
        average.add(&[0.0], 1_000_000);
        assert!((average.values[0] - 0.45).abs() < 1e-6, "{average:?}");
    }

    #[test]
    fn what_was_saved_goes_on_bit_for_bit() {
        let (layout, mut values) = (layout(), vec![1.0_f32, 2.0, 3.0]);
        let fresh = || SupervisedCore::new(AdamConfig::adam(), 3).with_average(0.9, vec![0.0; 3]);
        let mut core = fresh();
        core.step(&layout, &mut values, 1.0, descent(&[0.1, 0.2, 0.3]), Decay::NONE);
        core.step(&layout, &mut values, 1.0, descent(&[f32::NAN; 3]), Decay::NONE);
        core.validated(0.5, &values);
        core.validated(0.4, &[0.0; 3]);
        assert_eq!(core.best(), Some(values.as_slice()));
        let mut file = Checkpoint::new();
        core.save_into(&layout, &mut file, "training").unwrap();
        let mut other = fresh();
        other.load_from(&layout, &file, "training").unwrap();
        assert_eq!(other, core);
    }
}
