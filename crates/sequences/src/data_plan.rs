//! What the plans of all experiments have in common.

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::SequencesError;
use lifelike_representation::spline_transformer::SequencePlan;

/// Which sequences there are, and how an autoencoder is trained on them: what a run's plan.toml holds.
pub trait DataPlan: Clone + PartialEq + Serialize + DeserializeOwned {
    /// Network and training.
    fn training(&self) -> &SequencePlan;

    /// The same, to be changed.
    fn training_mut(&mut self) -> &mut SequencePlan;

    /// Checks every range.
    ///
    /// # Errors
    /// The first key out of range; parts that do not go together.
    fn check(&self) -> Result<(), SequencesError>;
}
