//! Floor 3: many worlds at once.
//!
//! The main path: [`Simulation`] (the trait every engine implements) → [`BatchState`] (what it reports, structure of
//! arrays) → [`randomization`] (thesis 4.2.2) → an engine, such as [`mujoco`].

pub mod batch;
pub mod error;
#[cfg(feature = "mujoco")]
pub mod mujoco;
pub mod randomization;

pub use batch::{BatchState, Drive, EnvironmentParameters, IntegrationState, Simulation};
pub use error::SimError;
