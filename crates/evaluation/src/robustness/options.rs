//! Extent of a sweep.

use super::disturbance::Disturbance;
use crate::EvaluationOptions;

/// How much is tried.
#[derive(Debug, Clone, PartialEq)]
pub struct RobustnessOptions {
    /// Seed of directions, moments, places, offsets and hills.
    pub seed: u64,
    /// Few sizes instead of all.
    pub few: bool,
    /// What is done to the robot.
    pub disturbances: Vec<Disturbance>,
    /// The episodes.
    pub evaluation: EvaluationOptions,
}
