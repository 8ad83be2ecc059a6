//! Which physics this build has.

use std::sync::Arc;

use lifelike_robot::{Robot, Severity, Shapes};
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
    /// Refuses a robot that cannot be trained in this engine, and tells what is doubtful about it.
    ///
    /// # Errors
    /// The verdict on the robot.
    pub fn require_ready(&self, robot: &Robot) -> Result<(), CliError> {
        let shapes = if self.engine == EngineKind::Mujoco { Shapes::All } else { Shapes::Primitives };
        robot.require_ready(shapes)?;
        let warnings = robot.readiness(shapes).problems.into_iter().filter(|p| p.severity == Severity::Warning);
        // Loading has told its own.
        for doubt in warnings.filter(|p| !robot.character.warnings.contains(&p.problem)) {
            tracing::warn!("robot '{}': {}; {}", robot.name, doubt.problem, doubt.remedy);
        }
        Ok(())
    }

    /// Makes so many environments of a robot, on a terrain or on level ground.
    ///
    /// # Errors
    /// [`CliError`] where the engine cannot simulate the robot.
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
