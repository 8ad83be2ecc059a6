//! Which physics this build has.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_augmentation::{ActuatorCorrection, Augmentation, AugmentationError, Feedback};
use lifelike_robot::{Robot, Severity, Shapes};
use lifelike_sim::Augmented;
use lifelike_sim::twin::{Twin, TwinSpec};
use lifelike_sim::{EngineKind, SimError, Simulation, SimulationSpec, Terrain};

use crate::error::CliError;

/// Which physics a command runs, and on how many threads.
#[derive(Debug, Clone, clap::Args)]
pub struct Physics {
    /// Physics engine.
    #[arg(long, default_value_t)]
    pub engine: EngineKind,
    /// Threads of the physics; one per processor where not given. Results do not depend on it.
    #[arg(long, default_value_t = 0, value_parser = crate::bounds::threads)]
    pub threads: usize,
    /// Correct the simulated joints by what was learned from logs: an augmentation of `lifelike train augmentation`. It corrects the joints of
    /// the profile's group of actuators that has its class' name; all joints where no group has. May be given once for each class.
    #[arg(long, value_name = "FILE")]
    pub augment: Vec<PathBuf>,
    /// Run on a twin in place of the nominal robot: real motors, friction, play, flex, delay, encoders, crooked parts, drawn by this seed
    /// (`lifelike augment twin --help`).
    #[arg(long, value_name = "SEED", conflicts_with = "augment")]
    pub twin: Option<u64>,
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
        if let Some(seed) = self.twin {
            return Ok(Box::new(Twin::new(robot, &TwinSpec { seed, ..TwinSpec::default() }, &spec)?));
        }
        let simulation = spec.build(Arc::clone(robot))?;
        let simulation = self.augment.iter().try_fold(simulation, |simulation, file| augmented(simulation, file))?;
        Ok(simulation)
    }
}

/// Corrects the joints that an augmentation's class names.
fn augmented(simulation: Box<dyn Simulation>, file: &Path) -> Result<Box<dyn Simulation>, SimError> {
    let robot = simulation.robot().clone();
    let refused = |error: AugmentationError| SimError::Model {
        engine: "augmentation",
        character: robot.name.clone(),
        message: error.to_string(),
    };
    let augmentation = Augmentation::load(file).map_err(refused)?;
    let class = &augmentation.header().inputs.class;
    let joints: Vec<String> =
        robot.layout.joints.iter().filter(|joint| robot.actuator_group(joint) == Some(class)).cloned().collect();
    if joints.is_empty() {
        let groups: Vec<&String> = robot.profile.actuator.keys().collect();
        tracing::warn!(
            "augmentation of '{class}': '{}' has no group of actuators of that name (it has {groups:?}); correcting all joints",
            robot.name
        );
    }
    let correction = ActuatorCorrection::new(augmentation, &robot, &joints, Feedback::None).map_err(refused)?;
    Ok(Box::new(Augmented::new(simulation, Box::new(correction))?))
}

/// Refuses an engine whose library is missing, and says how to get it.
///
/// # Errors
/// [`CliError::Unavailable`].
pub fn available(engine: &EngineKind) -> Result<(), CliError> {
    Ok(engine.available()?)
}
