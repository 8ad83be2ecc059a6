//! How much is tried, and on what ground.

use std::sync::Arc;

use lifelike_sim::{Simulation, Terrain};

use super::disturbance::Disturbance;
use crate::EvaluationError;
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

/// Makes simulations: on a terrain or on level ground, of so many environments.
pub type Ground<'a> = &'a dyn Fn(Option<Arc<Terrain>>, usize) -> Result<Box<dyn Simulation>, EvaluationError>;
