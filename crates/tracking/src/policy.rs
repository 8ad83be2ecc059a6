//! A policy in training as a controller's file (`*.controller.safetensors`), with what a training goes on with.
//!
//! Beside the controller's own arrays the file has the width of the exploration noise and the value function. A training
//! begins with them (`init`); nothing that acts needs them, and `lifelike export` leaves them out.

use std::path::Path;
use std::sync::Arc;

use lifelike_checkpoint::Checkpoint;
use lifelike_nn::normalizer::RunningNormalizer;
use lifelike_robot::controller::{ControllerHeader, PriorEncoder};
use lifelike_robot::{Controller, ControllerFile, Robot};

use crate::{FromInput, TrackerError};
use lifelike_train::networks::{Actor, Critic};
use lifelike_train::ppo::SavedNetworks;

/// A policy as a training has it.
#[derive(Debug, Clone)]
pub struct Policy {
    header: ControllerHeader,
    actor: Actor,
    normalizer: RunningNormalizer,
    robot: Arc<Robot>,
    prior: Option<PriorEncoder>,
    value: Option<(Critic, RunningNormalizer)>,
}

/// Names of the networks in the file.
const ACTOR: &str = "actor";
const NORMALIZER: &str = "normalizer";
const CRITIC: &str = "critic";
const CRITIC_NORMALIZER: &str = "critic_normalizer";

/// Returns the names of the networks in a policy's file.
pub(crate) fn networks() -> SavedNetworks {
    SavedNetworks {
        actor: ACTOR.into(),
        actor_normalizer: NORMALIZER.into(),
        critic: CRITIC.into(),
        critic_normalizer: CRITIC_NORMALIZER.into(),
    }
}

impl Policy {
    /// Returns the policy of a network in training.
    pub fn new(header: ControllerHeader, actor: &Actor, normalizer: &RunningNormalizer, robot: Arc<Robot>) -> Self {
        let mut normalizer = normalizer.clone();
        normalizer.set_frozen(true);
        Self { header, actor: actor.clone(), normalizer, robot, prior: None, value: None }
    }

    /// With the encoder of the latent codes that it sees.
    #[must_use]
    pub fn with_prior(self, prior: Option<PriorEncoder>) -> Self {
        Self { prior, ..self }
    }

    /// With the value function, so that a training that begins with the file (`init`) goes on with both.
    #[must_use]
    pub fn with_value(self, critic: &Critic, normalizer: &RunningNormalizer) -> Self {
        Self { value: Some((critic.clone(), normalizer.clone())), ..self }
    }

    /// Returns the outputs of the deterministic policy: `[N, O]` observations as `ObservationSpec::write` wrote them → `[N, J]` outputs (not
    /// clamped).
    ///
    /// # Errors
    /// The length is no multiple of the observation's.
    pub fn outputs(&self, mut observations: Vec<f32>) -> Result<Vec<f32>, TrackerError> {
        let width = self.header.observation.size();
        if !observations.len().is_multiple_of(width) {
            let expected = format!("rows of {width} numbers");
            return Err(TrackerError::mismatch("observations", expected, format!("{} numbers", observations.len())));
        }
        self.normalizer.normalize(&mut observations);
        Ok(self.actor.means(&observations))
    }

    /// Returns the controller that acts as the policy does.
    ///
    /// # Errors
    /// Header, networks and prior do not fit each other.
    pub fn controller(&self) -> Result<Controller, TrackerError> {
        let file = ControllerFile::new(self.header.clone(), &self.arrays()?, self.prior.clone(), &self.robot)?;
        Ok(Controller::new(file, Arc::clone(&self.robot))?)
    }

    /// Returns the arrays of the policy itself.
    fn arrays(&self) -> Result<Checkpoint, TrackerError> {
        let mut arrays = Checkpoint::new();
        self.actor.parameters().save_into(&mut arrays, ACTOR)?;
        self.normalizer.save_into(&mut arrays, NORMALIZER)?;
        Ok(arrays)
    }

    /// Returns the file's content.
    ///
    /// # Errors
    /// As [`Self::controller`].
    pub fn to_checkpoint(&self) -> Result<Checkpoint, TrackerError> {
        let mut checkpoint = self.controller()?.file().to_checkpoint()?;
        for (name, entry) in self.arrays()?.entries() {
            if !checkpoint.contains(name) {
                checkpoint.put(name, entry.clone())?;
            }
        }
        if let Some((critic, normalizer)) = &self.value {
            critic.parameters().save_into(&mut checkpoint, CRITIC)?;
            normalizer.save_into(&mut checkpoint, CRITIC_NORMALIZER)?;
        }
        Ok(checkpoint)
    }

    /// Writes the file; it appears under its name only when it is complete.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), TrackerError> {
        Ok(self.to_checkpoint()?.save(path)?)
    }
}
