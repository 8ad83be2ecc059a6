//! Everything that evaluations of one controller have in common.

use std::sync::Arc;

use lifelike_checkpoint::FromInput;
use lifelike_robot::{Controller, LatentEncoder, Robot};
use lifelike_sim::{SimError, Simulation, Terrain};

use super::error::EvaluationError;

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

    /// Returns the encoder of the latent codes that the policy asks for; none where it asks for none.
    pub(super) fn latent_encoder(&self) -> Result<Option<&'a dyn LatentEncoder>, EvaluationError> {
        let wanted = self.controller.observation().reference.latent;
        if wanted == 0 {
            return Ok(None);
        }
        let own = self.controller.prior().map(|prior| prior as &dyn LatentEncoder);
        let encoder = self.encoder.or(own);
        let got = encoder.map_or(0, |encoder| encoder.latent_size());
        if got == wanted {
            return Ok(encoder);
        }
        Err(EvaluationError::mismatch("latent codes for the policy", format!("{wanted} numbers"), got))
    }
}
