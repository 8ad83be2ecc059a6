//! Physical alignment (thesis 5.2.2): a trained generator is fine-tuned with L_MDM − β Σ_t v(m_t) (eq. 5.7), v being a
//! frozen [`RewardSurrogate`].
//!
//! [`AlignTrainer`] is a [`crate::training::GeneratorTrainer`] that starts from the generator's weights and adds the
//! surrogate's gradient to its loss. A [`PhysicsJudge`], which the command passes in, chooses the weights and so guards
//! against an exploited surrogate.

mod judge;
mod plan;
mod task;

use std::sync::Arc;

pub use judge::{JudgePlan, PhysicsJudge, PhysicsMarks};
pub use plan::AlignPlan;
pub use task::{AlignMarks, AlignTrainer};

use crate::GenerationError;
use crate::critic::RewardSurrogate;
use crate::representation::Standardizer;
use crate::space::MotionSpace;

/// The surrogate's part of the loss.
#[derive(Debug, Clone)]
pub struct Alignment {
    /// v, frozen.
    pub surrogate: Arc<dyn RewardSurrogate>,
    /// β of eq. 5.7, for the sum of v over the rows of a motion, beside the mean squared error of its standardized tokens.
    pub beta: f64,
}

impl Alignment {
    /// Adds the gradient of −β Σ_t v(m_t) by predicted clean tokens, mean over a batch of `count` motions. `motions` are
    /// the numbers of tokens and the rows of each. Returns the sum of the motions' mean values over `count`.
    ///
    /// # Errors
    /// Motion and surrogate do not fit.
    pub(crate) fn add(
        &self,
        space: &MotionSpace,
        standardizer: &Standardizer,
        predicted: &[f32],
        motions: impl Iterator<Item = (usize, usize)>,
        count: usize,
        gradient: &mut [f32],
    ) -> Result<f64, GenerationError> {
        let (mut at, mut realism) = (0, 0.0);
        let share = -(self.beta / count as f64) as f32;
        for (size, rows) in motions {
            let tokens = &predicted[at..at + size];
            let (values, by) = by_tokens(self.surrogate.as_ref(), space, standardizer, tokens, rows)?;
            gradient[at..at + size].iter_mut().zip(by).for_each(|(sum, by)| *sum += share * by);
            realism += values.iter().map(|v| f64::from(*v)).sum::<f64>() / (rows * count) as f64;
            at += size;
        }
        Ok(realism)
    }
}

/// Returns v(m_t) of every row that standardized tokens stand for, and the gradient of their sum by those tokens: back
/// through the surrogate, the space's linear map, and the standard deviations.
///
/// # Errors
/// Tokens, space and surrogate do not fit.
pub(crate) fn by_tokens(
    surrogate: &dyn RewardSurrogate,
    space: &MotionSpace,
    standardizer: &Standardizer,
    tokens: &[f32],
    rows: usize,
) -> Result<(Vec<f32>, Vec<f32>), GenerationError> {
    let mut own = tokens.to_vec();
    standardizer.restore(&mut own);
    let (values, by_rows) = surrogate.gradient(&space.decode(&own, rows)?)?;
    let mut by = space.transposed(&by_rows)?;
    for token in by.chunks_exact_mut(space.width()) {
        token.iter_mut().zip(&standardizer.std).for_each(|(by, std)| *by *= std);
    }
    Ok((values, by))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::representation::{FeatureMatrix, RepresentationSpec};
    use crate::space::SpaceKind;

    /// v(m_t) = w · row_t + ½ |row_t|².
    #[derive(Debug)]
    struct Square(Vec<f32>);

    impl RewardSurrogate for Square {
        fn values(&self, motion: &FeatureMatrix) -> Result<Vec<f32>, GenerationError> {
            let value = |row: &[f32]| row.iter().zip(&self.0).map(|(x, w)| x * w + 0.5 * x * x).sum();
            Ok(motion.rows.chunks_exact(motion.width).map(value).collect())
        }

        fn gradient(&self, motion: &FeatureMatrix) -> Result<(Vec<f32>, FeatureMatrix), GenerationError> {
            let by = motion.rows.chunks_exact(motion.width).flat_map(|row| row.iter().zip(&self.0).map(|(x, w)| x + w));
            Ok((self.values(motion)?, FeatureMatrix::new(by.collect(), motion.width)?))
        }
    }

    #[test]
    fn the_gradient_by_tokens_is_that_of_differences_in_both_spaces() {
        let spec = RepresentationSpec::new(vec!["hip".into(), "knee".into()]);
        for kind in [SpaceKind::Frames, SpaceKind::default()] {
            let space = MotionSpace::new(spec.clone(), kind);
            let width = space.width();
            let std = (0..width).map(|i| 0.2 + 0.1 * i as f32).collect();
            let standardizer = Standardizer { mean: vec![0.3; width], std };
            let surrogate = Square((0..spec.width()).map(|i| (i as f32).sin()).collect());
            let rows = 25;
            let size = space.tokens(rows) * width;
            let mut rng = lifelike_checkpoint::rng::stream(2, "test", 0, 0);
            let tokens = lifelike_nn::init::normal(&mut rng, size, 1.0);
            let (_, by) = by_tokens(&surrogate, &space, &standardizer, &tokens, rows).unwrap();
            let sum = |tokens: &[f32]| -> f64 {
                let (values, _) = by_tokens(&surrogate, &space, &standardizer, tokens, rows).unwrap();
                values.iter().map(|v| f64::from(*v)).sum()
            };
            let largest = by.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
            for i in (0..size).step_by(5) {
                let at = |delta: f32| {
                    let mut tokens = tokens.clone();
                    tokens[i] += delta;
                    sum(&tokens)
                };
                // The surrogate is a parabola: wide differences are exact but for single precision's 1e-7 of the sum.
                let expected = (at(0.5) - at(-0.5)) as f32;
                assert!((by[i] - expected).abs() < 1e-3 * largest, "{kind:?} {i}: {} for {expected}", by[i]);
            }
            // Of a batch of four, one motion: −β/4 of it, and a fourth of its mean.
            let total = sum(&tokens);
            let alignment = Alignment { surrogate: Arc::new(surrogate), beta: 0.5 };
            let mut gradient = vec![1.0; size];
            let motions = [(size, rows)].into_iter();
            let realism = alignment.add(&space, &standardizer, &tokens, motions, 4, &mut gradient).unwrap();
            assert!((realism - total / 100.0).abs() < 1e-5 * realism.abs());
            assert!(gradient.iter().zip(&by).all(|(g, by)| (g - (1.0 - 0.125 * by)).abs() <= 1e-6 * largest));
        }
    }
}
