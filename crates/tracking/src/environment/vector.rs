//! The environments as a [`VectorEnvironment`], in which PPO learns.

use lifelike_train::{StepOutcome, VectorEnvironment};

use super::Environment;
use crate::TrackerError;

impl VectorEnvironment for Environment {
    type Error = TrackerError;

    fn environments(&self) -> usize {
        self.len()
    }

    fn address(&self, i: usize) -> u64 {
        Self::address(self, i)
    }

    fn observation_size(&self) -> usize {
        self.actor_size()
    }

    fn window_size(&self) -> usize {
        let (spec, network) = (self.observation(), &self.setup.plan.network);
        if network.memory > 0 { spec.history_size() } else { spec.window_size() }
    }

    fn window_steps(&self) -> usize {
        if self.setup.plan.network.memory > 0 { self.observation().reference.history } else { 0 }
    }

    fn critic_observation_size(&self) -> usize {
        self.critic_size()
    }

    fn action_size(&self) -> usize {
        self.setup.robot.joints()
    }

    fn observations(&self) -> &[f32] {
        self.actor_rows()
    }

    fn critic_observations(&self) -> &[f32] {
        self.critic_rows()
    }

    fn teach(&self, actions: &mut Vec<f32>) -> Result<(), TrackerError> {
        self.taught(actions);
        Ok(())
    }

    fn step(&mut self, actions: &[f32], outcome: &mut StepOutcome) -> Result<(), TrackerError> {
        Self::step(self, actions, outcome)
    }
}
