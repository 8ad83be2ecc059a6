//! Floor 3: many environments at once.
//!
//! The main path: [`SimulationSpec`] (engine, ground, number of environments, threads) → [`Simulation`] (the trait of every
//! engine) → [`BatchState`] (its outputs, structure of arrays). Around it: [`randomization`] (thesis 4.2.2) and [`Terrain`].
//!
//! Engines are declared in one place, [`EngineKind`]: our own ([`engine`]), and MuJoCo as its oracle and for a second
//! opinion. Each is an [`Engine`] with the shared bookkeeping of [`Batched`] around it.

pub mod augmented;
pub mod batch;
pub mod batched;
pub mod bench;
mod checks;
pub mod constraint_wrenches;
pub mod engine;
pub mod error;
pub mod fallen;
mod ground;
pub mod mujoco;
pub mod randomization;
pub mod registry;
mod rows;
pub mod simulation;
pub mod terrain;
pub mod testing;
pub mod throughput;
pub mod trace;
pub mod twin;
mod workers;

pub use augmented::{Augmented, StateCorrection};
pub use batch::{BatchState, EnvironmentParameters, IntegrationState};
pub use batched::{Batched, Engine};
pub use constraint_wrenches::ConstraintWrenches;
pub use engine::LifelikeSimulation;
pub use error::SimError;
pub use ground::Ground;
pub use mujoco::MujocoSimulation;
pub use registry::{EngineKind, SimulationSpec};
pub use simulation::{Drive, Simulation};
pub use terrain::Terrain;

/// The example of the README, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
