//! Training of a generator: captioned motion and a [`GeneratorPlan`] → [`GeneratorTrainer`], a
//! [`lifelike_train::TrainingTask`] that leaves `motion.generator.safetensors`.

mod batch;
mod data;
mod plan;
mod task;
mod trainer;

pub use data::TrainingData;
pub use plan::GeneratorPlan;
pub use trainer::{GeneratorMetrics, GeneratorTrainer};
