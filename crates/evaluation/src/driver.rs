//! Runs a policy in physics, from states of the reference.

use std::sync::Arc;

use lifelike_motion::MotionClip;
use lifelike_robot::{LatentEncoder, Robot};
use lifelike_sim::Simulation;

use super::course::Course;
use super::hardship::Hardship;
use super::options::EvaluationOptions;
use super::score::Evaluation;
use crate::EvaluationError;
use lifelike_tracking::Policy;

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
    prior: Option<&dyn LatentEncoder>,
    simulation: Box<dyn Simulation>,
    options: &EvaluationOptions,
    progress: impl FnMut(usize, usize),
) -> Result<Evaluation, EvaluationError> {
    Course::new(policy, robot, clips, prior, options)?.run(simulation, |_| Hardship::default(), progress)
}
