//! Many environments that step together: what PPO collects experience in.

use crate::TrainError;

/// Environments of one kind that take their steps together, each with episodes of its own.
///
/// An environment whose episode ends in a step begins another one within the same step: afterwards its observations are those
/// of the new episode. [`crate::cart_pole::CartPole`] is a small one to read.
///
/// # Shapes
/// `N` environments, `O` numbers of an observation, `P` of the value function's, `A` of an action; rows one after another.
pub trait VectorEnvironment: Send {
    /// Error of an environment that fails as a whole.
    type Error: From<TrainError> + Send;

    /// Returns the number of environments N.
    fn environments(&self) -> usize;

    /// Returns the address of environment `i`'s randomness: its number among those of all processes.
    fn address(&self, i: usize) -> u64 {
        i as u64
    }

    /// Returns the length O of a row of [`Self::observations`].
    fn observation_size(&self) -> usize;

    /// Returns the length of the last part of an observation, which an encoder reads where the policy has one.
    fn window_size(&self) -> usize {
        0
    }

    /// Returns the steps that this part consists of, for an encoder that is recurrent; 0 where it has none.
    fn window_steps(&self) -> usize {
        0
    }

    /// Returns the length P of a row of [`Self::critic_observations`].
    fn critic_observation_size(&self) -> usize {
        self.observation_size()
    }

    /// Returns the length A of an action.
    fn action_size(&self) -> usize;

    /// Returns the policy's observations of now, `[N, O]`, not normalised.
    fn observations(&self) -> &[f32];

    /// Returns the value function's observations of now, `[N, P]`, not normalised: the policy's, or more.
    fn critic_observations(&self) -> &[f32] {
        self.observations()
    }

    /// Appends what a teacher would do now, `[N, A]`, where there is one: the policy then learns to do the same (DAgger, Ross et al.
    /// 2011) instead of from rewards.
    ///
    /// # Errors
    /// The environments fail as a whole.
    fn teach(&self, _actions: &mut Vec<f32>) -> Result<(), Self::Error> {
        Ok(())
    }

    /// Takes one step in all environments with the policy's outputs, `[N, A]` (not clamped), and fills in the outcome.
    ///
    /// # Errors
    /// `actions` has the wrong length, or the environments fail as a whole. One that diverges is no error: it terminates.
    fn step(&mut self, actions: &[f32], outcome: &mut StepOutcome) -> Result<(), Self::Error>;
}

/// Outcome of one step of N environments.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StepOutcome {
    /// Reward, `[N]`.
    pub rewards: Vec<f32>,
    /// Episodes that ended with nothing to follow (a failure, a goal), `[N]`.
    pub terminated: Vec<bool>,
    /// Episodes that were cut although something would have followed (a time limit), `[N]`.
    pub truncated: Vec<bool>,
    /// The value function's observations of the last states of the truncated episodes, in the environments' order,
    /// `[truncated, P]`: the rows of [`VectorEnvironment::critic_observations`] already belong to the next episodes.
    pub final_critic_observations: Vec<f32>,
}

impl StepOutcome {
    /// Empties all lists; their memory stays.
    pub fn clear(&mut self) {
        self.rewards.clear();
        self.terminated.clear();
        self.truncated.clear();
        self.final_critic_observations.clear();
    }
}
