//! Floor 3: many worlds at once.
//!
//! The main path: [`Simulation`] (the trait every engine implements) → [`BatchState`] (what it reports, structure of
//! arrays) → [`randomization`] (thesis 4.2.2) → an engine, made by [`create`]: our own
//! ([`engine`]), or MuJoCo behind a cargo feature as its oracle and for a second opinion.

pub mod batch;
mod checks;
pub mod engine;
pub mod error;
mod ground;
#[cfg(feature = "mujoco")]
pub mod mujoco;
pub mod randomization;
mod rows;
pub mod terrain;
#[cfg(feature = "testing")]
pub mod testing;
pub mod throughput;

use std::sync::Arc;

use lifelike_robot::Robot;

pub use batch::{BatchState, Drive, EnvironmentParameters, IntegrationState, Simulation};
pub use engine::LifelikeSimulation;
pub use error::SimError;
pub use ground::Ground;
#[cfg(feature = "mujoco")]
pub use mujoco::MujocoSimulation;
pub use terrain::Terrain;

/// Makes the engine of this name: `environments` copies of a robot, stepped by `threads` threads (0: one per processor).
///
/// # Errors
/// [`SimError::Engine`] when this build has no such engine; else what the engine says.
pub fn create(
    name: &str,
    robot: Arc<Robot>,
    environments: usize,
    threads: usize,
) -> Result<Box<dyn Simulation>, SimError> {
    create_on(None, name, robot, environments, threads)
}

/// The same on uneven ground; `None`: on level ground.
///
/// # Errors
/// As [`create`].
pub fn create_on(
    terrain: Option<Arc<Terrain>>,
    name: &str,
    robot: Arc<Robot>,
    environments: usize,
    threads: usize,
) -> Result<Box<dyn Simulation>, SimError> {
    match name {
        engine::ENGINE => {
            let simulation = LifelikeSimulation::new(robot, environments, threads)?;
            Ok(Box::new(match terrain {
                Some(terrain) => simulation.with_terrain(terrain),
                None => simulation,
            }))
        }
        #[cfg(feature = "mujoco")]
        mujoco::ENGINE => Ok(Box::new(MujocoSimulation::on(terrain.as_deref(), robot, environments, threads)?)),
        _ => {
            let hint = if cfg!(feature = "mujoco") {
                "there are 'lifelike' and 'mujoco'"
            } else {
                "there is 'lifelike'; for 'mujoco' build with the feature of that name (after `cargo xtask mujoco`)"
            };
            Err(SimError::Engine { name: name.to_string(), hint })
        }
    }
}
