//! Learning a class' augmentation from traces: [`AugmentationPlan`], [`AugmentationTrainer`] (a
//! [`lifelike_train::TrainingTask`]).

mod feedback;
mod plan;
mod task;
mod trainer;

pub use crate::loss::{Loss, LossKind};
pub use plan::{AugmentationPlan, FeedbackShares};
pub use trainer::AugmentationTrainer;
