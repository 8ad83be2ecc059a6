//! The stage of the curriculum: what is in force of the plan's difficulties.

use lifelike_sim::randomization::RandomizationSpec;

use crate::plan::TrackerPlan;
use crate::terminations::Termination;

/// Values in force at a stage of the curriculum.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Stage {
    /// Differences between environments.
    pub(super) randomization: RandomizationSpec,
    /// Limits beyond which an episode has failed.
    pub(super) limits: Termination,
    /// Factor on the penalties of actions and torques.
    pub(super) smoothness: f32,
}

impl Stage {
    /// Returns the stage after so many environment steps over all environments.
    pub(super) fn at(plan: &TrackerPlan, steps: u64) -> Self {
        let [share, forgiving, smoothness] = plan.curriculum.at(steps);
        let randomization = match plan.curriculum.randomization {
            Some(_) => plan.randomization.scaled(share),
            None => plan.randomization.clone(),
        };
        let limits = match plan.curriculum.termination {
            Some(_) => plan.termination.scaled(forgiving),
            None => plan.termination,
        };
        Self { randomization, limits, smoothness: smoothness as f32 }
    }
}
