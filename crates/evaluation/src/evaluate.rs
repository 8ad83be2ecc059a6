//! The main path: a controller in its physics, on clips, undisturbed.

use lifelike_motion::MotionClip;

use super::episode::EpisodeConditions;
use super::error::EvaluationError;
use super::evaluation::Evaluation;
use super::options::EvaluationOptions;
use super::setup::EvaluationSetup;
use super::suite::EvaluationSuite;

impl EvaluationSetup<'_> {
    /// Evaluates on clips, deterministically: no noise, no randomisation, the mean of the policy. The scores do not depend
    /// on how many episodes run at once. `progress` is told how many episodes are done, of how many.
    ///
    /// # Errors
    /// A clip does not fit the robot, or the simulation fails as a whole.
    pub fn evaluate(
        &self,
        clips: &[MotionClip],
        options: &EvaluationOptions,
        progress: impl FnMut(usize, usize),
    ) -> Result<Evaluation, EvaluationError> {
        let suite = EvaluationSuite::new(self, clips, options)?;
        let environments = suite.episodes().len().clamp(1, self.environments.max(1));
        suite.run((self.simulate)(None, environments)?, |_| EpisodeConditions::default(), progress)
    }
}
