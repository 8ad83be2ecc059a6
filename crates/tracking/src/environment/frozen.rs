//! Rollouts of a frozen controller: its rewards along references, with all that makes training hard (thesis Algorithm 1,
//! lines 3 to 13).

use std::sync::Arc;

use lifelike_robot::Controller;
use lifelike_robot::controller::PolicyWorkspace;
use lifelike_train::{RewardRecords, StepEnd, StepOutcome};

use super::Environment;
use crate::plan::{Curriculum, TrackerPlan};
use crate::{FromInput, TrackerError};

impl TrackerPlan {
    /// Returns the plan of environments for a frozen controller: reward, terminations, randomisation, pushes and noise
    /// are this plan's, at the end of its curriculum; observations and meaning of outputs are the controller's. Clips
    /// are drawn alike, and its failures no more often.
    #[must_use]
    pub fn frozen(&self, controller: &Controller, environments: usize) -> Self {
        let (header, mut plan) = (controller.header(), self.clone());
        plan.inputs = header.observation.reference.clone();
        plan.anchor = header.observation.anchor;
        plan.linear_velocity = header.observation.linear_velocity;
        plan.action = header.action;
        plan.curriculum = Curriculum::default();
        plan.rsi.failure_share = 0.0;
        plan.ppo.environments = environments;
        plan
    }
}

impl Environment {
    /// Lets a frozen controller act for a number of steps, from the present states on, and returns its rewards. `each` is told
    /// the steps done.
    ///
    /// # Errors
    /// The controller observes or moves something else than the environments, which [`TrackerPlan::frozen`] makes
    /// fit; the simulation fails as a whole.
    pub fn record(
        &mut self,
        controller: &Controller,
        steps: u64,
        mut each: impl FnMut(u64),
    ) -> Result<RewardRecords, TrackerError> {
        self.check(controller)?;
        let library = Arc::clone(&self.setup.library);
        let mut records = RewardRecords::new(library.names.clone(), self.setup.robot.control_hz, self.len());
        let mut work = PolicyWorkspace::batched();
        let mut rows = vec![0.0; self.actor_rows().len()];
        let mut outputs = vec![0.0; self.len() * self.setup.robot.joints()];
        let mut outcome = StepOutcome::default();
        for done in 1..=steps {
            for episode in self.episodes() {
                let clip = library.clip_of(episode.frame);
                records.sequence.push(clip as u32);
                records.frame.push((episode.frame - library.starts[clip]) as u32);
            }
            rows.copy_from_slice(self.actor_rows());
            controller.outputs(&mut rows, &mut work, &mut outputs);
            self.step(&outputs, &mut outcome)?;
            records.reward.extend_from_slice(&outcome.rewards);
            for (i, episode) in self.episodes().iter().enumerate() {
                records.end.push(match (outcome.terminated[i], outcome.truncated[i], episode.finished_segment) {
                    (true, ..) => StepEnd::Failed,
                    (_, true, _) => StepEnd::Truncated,
                    (_, _, Some(_)) => StepEnd::Jumped,
                    _ => StepEnd::Continues,
                });
            }
            each(done);
        }
        Ok(records)
    }

    fn check(&self, controller: &Controller) -> Result<(), TrackerError> {
        let mismatch = |what: &str, expected: String, got: String| {
            Err(TrackerError::mismatch(format!("{what} of the controller"), expected, got))
        };
        let (own, header) = (self.observation(), controller.header());
        if own != &header.observation {
            return mismatch("observation", format!("{own:?}"), format!("{:?}", header.observation));
        }
        if self.setup.plan.action != header.action {
            return mismatch("action", format!("{:?}", self.setup.plan.action), format!("{:?}", header.action));
        }
        Ok(())
    }
}
