//! Parts that the plans of all experiments have in common.

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::SequencesError;
use lifelike_representation::spline_transformer::SequencePlan;

/// A data set and the training of an autoencoder on it: the content of a run's plan.toml.
pub trait DataPlan: Clone + PartialEq + Serialize + DeserializeOwned {
    /// Returns the settings of network and training.
    fn training(&self) -> &SequencePlan;

    /// Returns the same, to be changed.
    fn training_mut(&mut self) -> &mut SequencePlan;

    /// Checks every range.
    ///
    /// # Errors
    /// The first key out of range; parts that do not go together.
    fn check(&self) -> Result<(), SequencesError>;
}
