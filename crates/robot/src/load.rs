//! A robot by its name or file: those that come with the program, and everybody else's.

use std::path::{Path, PathBuf};

use lifelike_character::Character;

use crate::error::RobotError;
use crate::nearest::hint;
use crate::profile::Profile;
use crate::robot::Robot;

/// Their names.
pub const NAMES: [&str; 2] = ["lima", "humanoid"];

/// Profile of the Unitree G1, which stands beside its fetched model.
pub const G1_PROFILE: &str = include_str!("../robots/unitree_g1.toml");

/// Robots of other people that `lifelike fetch` gets: name, and file in the folder of robots.
pub const FETCHED: [(&str, &str); 1] = [("g1", "unitree_g1/g1.xml")];

/// Folder of fetched robots in a checkout.
const CHECKOUT: &str = "third_party/robots";

/// Returns the folder of the user's fetched files: `$XDG_DATA_HOME/lifelike`, or what the system has in its place.
pub fn data_folder() -> PathBuf {
    let set = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let home = || set("HOME");
    let found = set("XDG_DATA_HOME").or_else(|| match std::env::consts::OS {
        "windows" => set("LOCALAPPDATA"),
        "macos" => home().map(|home| home.join("Library/Application Support")),
        _ => home().map(|home| home.join(".local/share")),
    });
    found.unwrap_or_else(std::env::temp_dir).join("lifelike")
}

/// Returns the file of a fetched robot: in the checkout around the working directory, else in [`data_folder`]. A name that
/// is not one of [`FETCHED`], and a robot that was not fetched, have none.
pub fn fetched(name: &str) -> Option<PathBuf> {
    let (_, file) = FETCHED.iter().find(|(known, _)| *known == name)?;
    let here = std::env::current_dir().unwrap_or_default();
    let checkouts = here.ancestors().map(|folder| folder.join(CHECKOUT));
    checkouts.chain([data_folder().join("robots")]).map(|folder| folder.join(file)).find(|path| path.is_file())
}

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
        let path = fetched(name_or_path).unwrap_or_else(|| PathBuf::from(name_or_path));
        let path = path.as_path();
        if !path.is_file() {
            if FETCHED.iter().any(|(name, _)| *name == name_or_path) {
                return Err(RobotError::NotFetched { name: name_or_path.to_string() });
            }
            return Err(RobotError::Unknown {
                name: name_or_path.to_string(),
                available: known().collect::<Vec<_>>().join(", "),
                hint: hint(name_or_path, known()),
            });
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

/// Returns the names that [`Robot::load`] takes.
pub fn known() -> impl Iterator<Item = &'static str> {
    NAMES.into_iter().chain(FETCHED.iter().map(|(name, _)| *name))
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
