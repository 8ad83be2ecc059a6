//! A differentiable stand-in for the tracker.

use crate::GenerationError;
use crate::representation::FeatureMatrix;

/// Expected discounted reward at every row of a motion, in SI units, with its gradient by the motion.
pub trait RewardSurrogate: Send + Sync + std::fmt::Debug {
    /// Returns v(m_t) of every row, `[n]`.
    ///
    /// # Errors
    /// The rows are of another width.
    fn values(&self, motion: &FeatureMatrix) -> Result<Vec<f32>, GenerationError>;

    /// Returns v(m_t) of every row, `[n]`, and the gradient of their sum by every number of the motion, `[n, width]`.
    ///
    /// # Errors
    /// As [`Self::values`].
    fn gradient(&self, motion: &FeatureMatrix) -> Result<(Vec<f32>, FeatureMatrix), GenerationError>;
}
