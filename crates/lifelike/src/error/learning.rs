//! Errors of the crates that learn.

use lifelike_augmentation::AugmentationError;
use lifelike_generation::GenerationError;
use lifelike_representation::RepresentationError;
use lifelike_tracking::TrackerError;
use lifelike_train::{PlanError, TrainError};

use super::CliError;

impl From<PlanError> for CliError {
    fn from(error: PlanError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<TrainError> for CliError {
    fn from(error: TrainError) -> Self {
        match error {
            TrainError::Report(error) => error.into(),
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<RepresentationError> for CliError {
    fn from(error: RepresentationError) -> Self {
        match error {
            RepresentationError::Report(error) => error.into(),
            RepresentationError::Train(error) => error.into(),
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<GenerationError> for CliError {
    fn from(error: GenerationError) -> Self {
        match error {
            GenerationError::Report(error) => error.into(),
            GenerationError::Train(error) => error.into(),
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<AugmentationError> for CliError {
    fn from(error: AugmentationError) -> Self {
        match error {
            AugmentationError::Io { ref source, .. } => Self::io(source, error.to_string()),
            AugmentationError::Report(error) => error.into(),
            AugmentationError::Train(error) => error.into(),
            AugmentationError::Sim(error) => error.into(),
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<TrackerError> for CliError {
    fn from(error: TrackerError) -> Self {
        match error {
            TrackerError::Io { ref source, .. } => Self::io(source, error.to_string()),
            TrackerError::Simulation(error) => error.into(),
            TrackerError::Report(error) => error.into(),
            TrackerError::Train(error) => error.into(),
            _ => Self::Input(error.to_string()),
        }
    }
}
