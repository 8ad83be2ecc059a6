//! Extent of a sweep.

use super::disturbance::Disturbance;
use crate::EvaluationOptions;

/// Extent of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct RobustnessOptions {
    /// Seed of directions, moments, places, offsets and hills.
    pub seed: u64,
    /// Few sizes instead of all.
    pub few: bool,
    /// Sizes in place of the disturbances' own; empty: theirs.
    pub sizes: Vec<f64>,
    /// The disturbances.
    pub disturbances: Vec<Disturbance>,
    /// The episodes.
    pub evaluation: EvaluationOptions,
}

impl RobustnessOptions {
    /// Returns the sizes of a disturbance.
    pub(super) fn sizes_of(&self, disturbance: Disturbance) -> Vec<f64> {
        if self.sizes.is_empty() { disturbance.sizes(self.few) } else { self.sizes.clone() }
    }
}
