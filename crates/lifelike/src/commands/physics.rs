//! Which physics this build has.

use std::sync::Arc;

use lifelike_robot::{Robot, Severity, Shapes};
use lifelike_sim::{SimError, Simulation, Terrain};

use crate::error::CliError;

/// The engine where none is named.
pub const DEFAULT: &str = "lifelike";

/// Which physics a command runs, and on how many threads.
#[derive(Debug, Clone, clap::Args)]
pub struct Physics {
    /// Physics engine.
    #[arg(long, default_value = DEFAULT)]
    pub engine: String,
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
        let shapes = if self.engine == "mujoco" { Shapes::All } else { Shapes::Primitives };
        robot.require_ready(shapes)?;
        let warnings = robot.readiness(shapes).problems.into_iter().filter(|p| p.severity == Severity::Warning);
        // Loading has told its own.
        for doubt in warnings.filter(|p| !robot.character.warnings.contains(&p.problem)) {
            tracing::warn!("robot '{}': {}; {}", robot.name, doubt.problem, doubt.remedy);
        }
        Ok(())
    }

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
        lifelike_sim::create_on(terrain, &self.engine, Arc::clone(robot), environments, self.threads)
    }
}

/// Whether the engine is in this build; if not, how to get it.
pub fn available(engine: &str) -> Result<(), CliError> {
    match engine {
        "lifelike" => Ok(()),
        "mujoco" if cfg!(feature = "mujoco") => Ok(()),
        "mujoco" => Err(CliError::Unavailable(
            "this build has no MuJoCo. Leave --engine away for our own physics, or fetch MuJoCo once and build with it:\n\
             \x20 cargo xtask mujoco\n\
             \x20 cargo run --release --features mujoco --bin lifelike -- ..."
                .into(),
        )),
        other => Err(CliError::Usage(format!("no engine '{other}'; there are: lifelike, mujoco"))),
    }
}
