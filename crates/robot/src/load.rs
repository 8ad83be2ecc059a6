//! A robot by its name or file: those that come with the program, and everybody else's.

use std::path::Path;

use lifelike_character::Character;

use crate::error::RobotError;
use crate::profile::Profile;
use crate::robot::Robot;

/// Their names.
pub const NAMES: [&str; 2] = ["lima", "humanoid"];

/// Returns the MJCF and profile of a built-in robot.
fn texts(name: &str) -> Option<(&'static str, &'static str)> {
    match name {
        "lima" => Some((include_str!("../robots/lima.xml"), include_str!("../robots/lima.toml"))),
        "humanoid" => Some((include_str!("../robots/humanoid.xml"), include_str!("../robots/humanoid.toml"))),
        _ => None,
    }
}

impl Robot {
    /// Returns a robot by the name of a built-in one, or by the path of an MJCF or URDF file. A profile beside the file
    /// (`x.toml` beside `x.xml`) is read; without one everything is guessed, and [`Self::notes`] says what.
    ///
    /// # Errors
    /// [`RobotError::Unknown`] for a name that is neither; else whatever is wrong with the files.
    pub fn load(name_or_path: &str) -> Result<Self, RobotError> {
        if let Some(built_in) = builtin(name_or_path) {
            return built_in;
        }
        let path = Path::new(name_or_path);
        if !path.is_file() {
            return Err(RobotError::Unknown { name: name_or_path.to_string(), available: NAMES.join(", ") });
        }
        let character = Character::load(path)?;
        let beside = path.with_extension("toml");
        let profile = if beside.is_file() { Profile::from_file(&beside)? } else { Profile::default() };
        let mut robot = Self::from_character(character, profile)?;
        for warning in &robot.character.warnings {
            tracing::warn!("{warning}");
        }
        if !beside.is_file() {
            robot.notes.insert(0, format!("no profile {}: everything below is guessed", beside.display()));
        }
        Ok(robot)
    }
}

/// Returns the built-in robot of this name, if there is one. The texts are part of the program, so a test makes sure
/// that they are read without error.
fn builtin(name: &str) -> Option<Result<Robot, RobotError>> {
    let (mjcf, profile) = texts(name)?;
    let read = || {
        let character = Character::from_mjcf(mjcf, &format!("robots/{name}.xml"), None)?;
        let profile = Profile::from_toml(profile, Path::new(&format!("robots/{name}.toml")))?;
        Robot::from_character(character, profile)
    };
    Some(read())
}
