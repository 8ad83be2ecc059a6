//! The robot, policy and generator that a scene names.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use lifelike_generation::generator::Generator;
use lifelike_representation::motion_spline::MotionSpline;
use lifelike_robot::Robot;
use lifelike_studio::{Scene, Stage, StudioError, examples};

use crate::commands::controller_file::Loaded;
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
    let policy = scene.policy.as_deref().map(Path::new);
    let found = shipped::controller(policy, &robot, &scene.robot, || NextCommand::new("studio"))?;
    let Source { policy, prior, .. } = Source::of(&found)?;
    let loaded = Loaded::new(&policy, Arc::clone(&robot), prior.as_deref())?;
    if loaded.encoder().is_some() {
        let message = format!(
            "{}: expected a controller with its own encoder, got a policy that needs the file of its spline prior",
            policy.display()
        );
        return Err(CliError::Input(message));
    }
    let generator = shipped::of_robot(&robot, Kind::Generator).map(shipped::Shipped::file).transpose()?;
    let generator = generator.map(|file| Generator::load(&file)).transpose()?.map(Arc::new);
    let spline = shipped::of_robot(&robot, Kind::Spline).map(shipped::Shipped::file).transpose()?;
    let spline = spline.map(|file| MotionSpline::load(&file)).transpose()?.map(Arc::new);
    Ok(Stage { controller: Arc::new(loaded.controller), generator, spline, folder: folder(file) })
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
