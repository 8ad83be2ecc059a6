//! Everything that evaluations of one controller have in common.

use std::sync::Arc;

use lifelike_robot::{Controller, LatentEncoder, Robot};
use lifelike_sim::{SimError, Simulation, Terrain};

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
}
