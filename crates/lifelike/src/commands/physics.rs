//! Which physics this build has.

#[cfg(feature = "learning")]
use std::path::PathBuf;
use std::sync::Arc;

#[cfg(feature = "learning")]
use lifelike_augmentation::{ActuatorCorrection, Augmentation, AugmentationError, Feedback};
use lifelike_robot::{Robot, Severity, Shapes};
#[cfg(feature = "learning")]
use lifelike_sim::Augmented;
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
    /// Correct the simulated joints by what was learned from logs: an augmentation of `lifelike train augmentation`, for all joints.
    #[cfg(feature = "learning")]
    #[arg(long, value_name = "FILE")]
    pub augment: Option<PathBuf>,
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
        let spec = SimulationSpec { engine: self.engine, environments, threads: self.threads, terrain };
        let simulation = spec.build(Arc::clone(robot))?;
        #[cfg(feature = "learning")]
        if let Some(file) = &self.augment {
            let refused = |error: AugmentationError| SimError::Model {
                engine: "augmentation",
                character: robot.name.clone(),
                message: error.to_string(),
            };
            let augmentation = Augmentation::load(file).map_err(refused)?;
            let correction = ActuatorCorrection::new(augmentation, robot, &[], Feedback::None).map_err(refused)?;
            return Ok(Box::new(Augmented::new(simulation, Box::new(correction))?));
        }
        Ok(simulation)
    }
}

/// Refuses an engine that this build lacks, and says how to get it.
///
/// # Errors
/// [`CliError::Unavailable`].
pub fn available(engine: &EngineKind) -> Result<(), CliError> {
    Ok(engine.available()?)
}
