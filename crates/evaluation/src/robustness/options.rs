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
    /// The disturbances.
    pub disturbances: Vec<Disturbance>,
    /// The episodes.
    pub evaluation: EvaluationOptions,
}
