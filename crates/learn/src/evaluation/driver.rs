//! Runs a policy in physics, from states of the reference.

use std::sync::Arc;

use lifelike_motion::MotionClip;
use lifelike_robot::Robot;
use lifelike_sim::Simulation;

use super::course::Course;
use super::hardship::Hardship;
use super::score::Evaluation;
use crate::error::LearnError;
use crate::tracking::{Encode, Policy};

/// What to evaluate on.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EvaluationOptions {
    /// Longest episode (s). Cyclic clips are repeated to last that long; episodes of others end with their clip.
    pub seconds: f64,
    /// Episodes per clip, from start frames spread evenly.
    pub starts: usize,
    /// Rollouts of each clip that are kept to be looked at; the first that fell is always kept.
    pub keep: usize,
    /// How long a fall is recorded (s).
    pub after_fall: f64,
}

impl Default for EvaluationOptions {
    fn default() -> Self {
        Self { seconds: 10.0, starts: 5, keep: 1, after_fall: 1.0 }
    }
}

/// Evaluates a policy on clips, deterministically: no noise, no randomisation, the mean of the policy. As many episodes
/// run at once as the simulation has environments; the scores do not depend on how many.
///
/// `prior` gives the latent codes where the policy wants them. `progress` is told how many episodes are done, of how many.
///
/// # Errors
/// The policy does not fit the robot, a clip does not, or the simulation fails as a whole.
pub fn evaluate(
    policy: &Policy,
    robot: &Arc<Robot>,
    clips: &[MotionClip],
    prior: Option<&dyn Encode>,
    simulation: Box<dyn Simulation>,
    options: &EvaluationOptions,
    progress: impl FnMut(usize, usize),
) -> Result<Evaluation, LearnError> {
    Course::new(policy, robot, clips, prior, options)?.run(simulation, |_| Hardship::default(), progress)
}
