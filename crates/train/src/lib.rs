//! Floor 4: training for any task.
//!
//! There are two main paths. [`VectorEnvironment`] (many environments that step together) and [`ppo::PpoSpec`] →
//! [`ppo::Learner`], which learns a policy in it. [`TrainingTask`] (one step, its numbers, its checkpoint) and a run's
//! folder → [`TrainingRun::run`]. That is the one loop of all trainings: metrics, validation, checkpoints, Ctrl-C,
//! resume bit for bit, final report.
//!
//! ```
//! use std::sync::Arc;
//! use lifelike_train::cart_pole::CartPole;
//! use lifelike_train::collective::Alone;
//! use lifelike_train::ppo::{Learner, NetworkSpec, PpoSpec};
//!
//! let mut environment = CartPole::new(8, 200, 1);
//! let spec = PpoSpec { environments: 8, steps: 16, minibatch: 64, ..PpoSpec::default() };
//! let network = NetworkSpec { actor: vec![16], critic: vec![16], ..NetworkSpec::default() };
//! let mut learner = Learner::new(&spec, &network, 1, &environment, Arc::new(Alone));
//! let first = learner.iterate(&mut environment, 0)?;
//! assert_eq!(first.reward, 1.0); // mean reward per step
//! # Ok::<(), lifelike_train::TrainError>(())
//! ```

pub mod cart_pole;
pub mod collective;
pub mod encoder;
mod environment;
mod error;
pub mod gae;
pub mod gaussian;
mod kernels;
pub mod limits;
mod log_schedule;
pub mod losses;
pub mod networks;
pub mod plan;
pub mod ppo;
mod records;
mod run;
pub mod supervised;
mod task;

pub use environment::{StepOutcome, VectorEnvironment};
pub use error::TrainError;
use lifelike_checkpoint::FromInput;
pub use limits::PlanError;
pub use log_schedule::LogSchedule;
pub use records::{RewardRecords, StepEnd};
pub use run::{Progress, Summary, TrainingRun};
pub use task::{Budget, Scalar, Schedule, TrainingTask, Validation};
