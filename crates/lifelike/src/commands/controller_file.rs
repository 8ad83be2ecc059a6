//! A controller from its file, as commands take it: or a policy of before there were controllers, with its motion prior.

use std::path::Path;
use std::sync::Arc;

use lifelike_evaluation::{EvaluationSetup, SimulationFactory};
use lifelike_robot::{Controller, ControllerFile, LatentEncoder, Robot};

use crate::commands::export::Source;
use crate::commands::prior_file::Prior;
use crate::error::CliError;
use crate::next::is_known;

/// Most episodes that run at once.
const ENVIRONMENTS: usize = 128;

/// A controller for a robot, and the encoder of latent codes where it wants them and has none of its own.
pub struct Loaded {
    /// The controller.
    pub controller: Controller,
    encoder: Option<Prior>,
}

impl Loaded {
    /// Reads a controller, a policy, or the policy of a run, for the robot of this name or file. Without one, it takes
    /// the robot that it was trained for.
    pub fn load(path: &Path, robot: Option<&str>, prior: Option<&Path>) -> Result<Self, CliError> {
        let source = Source::of(path)?;
        let name = match robot.map(str::to_owned).or(source.robot) {
            Some(name) => name,
            None => robot_of(&ControllerFile::read(&source.policy)?).map_err(|reason| {
                CliError::Usage(format!(
                    "{}: {reason}; name its MJCF or URDF file with --robot",
                    source.policy.display()
                ))
            })?,
        };
        Self::for_robot(path, &Robot::load(&name)?, prior)
    }

    /// Reads a controller, a policy, or the policy of a run, for a robot whose joints are brought into the policy's order.
    pub fn for_robot(path: &Path, robot: &Robot, prior: Option<&Path>) -> Result<Self, CliError> {
        let source = Source::of(path)?;
        let file = ControllerFile::read(&source.policy)?;
        let robot = robot.clone().in_joint_order(&file.header().observation.joints)?;
        Self::new(&source.policy, Arc::new(robot), prior.or(source.prior.as_deref()))
    }

    /// Reads a controller or a policy for a robot that was loaded before.
    pub fn new(path: &Path, robot: Arc<Robot>, prior: Option<&Path>) -> Result<Self, CliError> {
        let controller = Controller::new(ControllerFile::read(path)?, robot)?;
        let encoder = Prior::for_controller(&controller, prior)?;
        Ok(Self { controller, encoder })
    }

    /// Returns the encoder of latent codes that is not part of the controller, where there is one.
    pub fn encoder(&self) -> Option<&dyn LatentEncoder> {
        self.encoder.as_ref().map(|prior| prior as &dyn LatentEncoder)
    }

    /// Sets up evaluations in this physics.
    pub fn setup<'a>(&'a self, simulate: &'a SimulationFactory<'a>) -> EvaluationSetup<'a> {
        let encoder = self.encoder();
        EvaluationSetup { controller: &self.controller, encoder, simulate, environments: ENVIRONMENTS }
    }
}

/// Returns the name of the robot that a controller was made for, where that is one with its joints: names in robots' files
/// repeat.
///
/// # Errors
/// The robot is none of those that are found by name.
pub fn robot_of(file: &ControllerFile) -> Result<String, String> {
    let header = file.header();
    let name = &header.robot;
    if is_known(name) {
        match Robot::load(name) {
            Ok(robot) if robot.layout.joints == header.observation.joints => return Ok(name.clone()),
            Ok(_) => return Err(format!("made for a robot called '{name}' that is not the built-in one of that name")),
            Err(error) => return Err(error.to_string()),
        }
    }
    // Files of fetched robots have names of their own.
    let same = |known: &&str| {
        Robot::load(known).is_ok_and(|robot| robot.name == *name && robot.layout.joints == header.observation.joints)
    };
    let found = lifelike_robot::load::known().find(same).map(str::to_owned);
    found.ok_or_else(|| format!("made for '{name}', which does not come with the program"))
}
