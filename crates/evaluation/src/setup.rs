//! Everything that evaluations of one controller have in common.

use std::sync::Arc;

use lifelike_motion::MotionClip;
use lifelike_robot::{Controller, LatentEncoder, Robot};
use lifelike_sim::{SimError, Simulation, Terrain};

use super::error::EvaluationError;
use super::options::EvaluationOptions;
use super::score::Evaluation;
use super::suite::EvaluationSuite;

/// Maker of simulations: on a terrain or on level ground, of so many environments.
pub type SimulationFactory<'a> = dyn Fn(Option<Arc<Terrain>>, usize) -> Result<Box<dyn Simulation>, SimError> + 'a;

/// A controller and the physics that it is evaluated in.
#[derive(Clone, Copy)]
pub struct EvaluationSetup<'a> {
    /// The controller, which knows its robot.
    pub controller: &'a Controller,
    /// Encoder of latent codes, where the policy wants them and the controller has none of its own.
    pub encoder: Option<&'a dyn LatentEncoder>,
    /// The physics.
    pub simulate: &'a SimulationFactory<'a>,
    /// Most episodes that run at once.
    pub environments: usize,
}

impl<'a> EvaluationSetup<'a> {
    /// The robot.
    pub fn robot(&self) -> &'a Arc<Robot> {
        self.controller.robot()
    }

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
        suite.run((self.simulate)(None, environments)?, |episode| suite.undisturbed(episode), progress)
    }
}
