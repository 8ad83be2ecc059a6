//! The robot, policy and generator that a scene names.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_generation::generator::Generator;
use lifelike_representation::MotionPrior;
use lifelike_representation::motion_spline::MotionSpline;
use lifelike_robot::controller::EXTENSION;
use lifelike_robot::{Controller, Robot};
use lifelike_studio::{Policies, Scene, Stage, StudioError, examples};

use crate::commands::export::Source;
use crate::error::CliError;
use crate::next::NextCommand;
use crate::shipped::{self, Kind};

/// Loads what a scene is performed with; its clips are read below the folder of its file.
///
/// # Errors
/// A robot or policy that is missing, or that do not fit each other.
pub fn open(scene: &Scene, file: &Path) -> Result<Stage, CliError> {
    let robot = Arc::new(Robot::load(&scene.robot)?);
    let controller = performing(scene.policy.as_deref(), &robot, &scene.robot)?;
    let policies = policies(scene, &robot, &folder(file));
    Ok(Stage { policies, ..with(controller, file)? })
}

/// Loads what the motion of a scene is made with, and lets this controller perform it.
///
/// # Errors
/// A network that cannot be read.
pub fn with(controller: Arc<Controller>, file: &Path) -> Result<Stage, CliError> {
    let robot = controller.robot();
    let generator = shipped::of_robot(robot, Kind::Generator).map(shipped::Shipped::file).transpose()?;
    let generator = generator.map(|file| Generator::load(&file)).transpose()?.map(Arc::new);
    let spline = shipped::of_robot(robot, Kind::Spline).map(shipped::Shipped::file).transpose()?;
    let spline = spline.map(|file| MotionSpline::load(&file)).transpose()?.map(Arc::new);
    let prior = shipped::of_robot(robot, Kind::Prior).map(shipped::Shipped::file).transpose()?;
    let prior = prior.map(|file| MotionPrior::load(&file)).transpose()?.map(Arc::new);
    let policies = Policies::default();
    Ok(Stage { controller, generator, spline, prior, folder: folder(file), policies })
}

/// Reads the policy of this name or file, the best for the robot where there is none.
fn performing(policy: Option<&str>, robot: &Arc<Robot>, robot_file: &str) -> Result<Arc<Controller>, CliError> {
    let found = shipped::controller(policy.map(Path::new), robot, robot_file, || NextCommand::new("studio"))?;
    let Source { policy, .. } = Source::of(&found)?;
    Ok(Arc::new(Controller::load(&policy, Arc::clone(robot))?))
}

/// Returns the policies that may perform: the scene's, those of the program for the robot, and those in its folder.
fn policies(scene: &Scene, robot: &Arc<Robot>, folder: &Path) -> Policies {
    let shipped = shipped::all().filter(|network| network.kind == Kind::Controller);
    let mut names: Vec<String> =
        shipped.filter(|network| network.fits(robot)).map(|network| network.stem().to_string()).collect();
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let files = files.map(|entry| entry.file_name().to_string_lossy().into_owned());
    let mut files: Vec<String> = files.filter(|name| name.ends_with(EXTENSION)).collect();
    files.sort();
    let (own, robot, robot_file, folder) =
        (files.clone(), Arc::clone(robot), scene.robot.clone(), folder.to_path_buf());
    names.extend(files);
    names.extend(scene.policy.clone().filter(|policy| !names.contains(policy)));
    let load = move |name: Option<&str>| {
        let name = name.map(|name| match own.iter().any(|file| file == name) {
            true => folder.join(name).display().to_string(),
            false => name.to_owned(),
        });
        performing(name.as_deref(), &robot, &robot_file).map_err(|error| error.to_string())
    };
    Policies { names, load: Some(Arc::new(load)) }
}

/// Returns the folder of a file, `.` for a bare name.
pub fn folder(file: &Path) -> PathBuf {
    let parent = file.parent().filter(|parent| !parent.as_os_str().is_empty());
    parent.unwrap_or(Path::new(".")).to_path_buf()
}

/// Returns the file of a scene. An example (`examples/dance`) is written into the working folder, unless it is there.
///
/// # Errors
/// A name that is neither a file nor an example.
pub fn file(given: &Path) -> Result<PathBuf, CliError> {
    if given.exists() {
        return Ok(given.to_path_buf());
    }
    let name = given.to_str().and_then(|text| text.strip_prefix("examples/"));
    let Some((name, text)) = name.and_then(examples::find) else {
        let names: Vec<String> = examples::ALL.iter().map(|(name, _)| format!("examples/{name}")).collect();
        return Err(CliError::Input(format!(
            "{}: expected a file *.scene.toml, or one of {}, got neither",
            given.display(),
            names.join(", ")
        )));
    };
    let path = PathBuf::from(format!("{name}{}", lifelike_studio::EXTENSION));
    if !path.exists() {
        crate::output::write(&path, text)?;
    }
    Ok(path)
}

impl From<StudioError> for CliError {
    fn from(error: StudioError) -> Self {
        match error {
            StudioError::Simulation(error) => error.into(),
            StudioError::Robot(error) => error.into(),
            StudioError::Motion(error) => error.into(),
            StudioError::Server(_) => Self::Failed(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}
