//! Which physics this build has.

use std::sync::Arc;

use lifelike_robot::Robot;
use lifelike_sim::{EngineKind, SimError, Simulation, SimulationSpec, Terrain};

use crate::error::CliError;

/// Which physics a command runs, and on how many threads.
#[derive(Debug, Clone, clap::Args)]
pub struct Physics {
    /// Physics engine.
    #[arg(long, default_value_t)]
    pub engine: EngineKind,
    /// Threads of the physics; one per processor where not given. Results do not depend on it.
    #[arg(long, default_value_t = 0)]
    pub threads: usize,
}

impl Physics {
    /// So many environments of a robot, on a terrain or on level ground.
    ///
    /// # Errors
    /// What the engine cannot simulate.
    pub fn simulate(
        &self,
        terrain: Option<Arc<Terrain>>,
        robot: &Arc<Robot>,
        environments: usize,
    ) -> Result<Box<dyn Simulation>, SimError> {
        SimulationSpec { engine: self.engine, environments, threads: self.threads, terrain }.build(Arc::clone(robot))
    }
}

/// Refuses an engine that this build lacks, and says how to get it.
///
/// # Errors
/// [`CliError::Unavailable`].
pub fn available(engine: &EngineKind) -> Result<(), CliError> {
    Ok(engine.available()?)
}
