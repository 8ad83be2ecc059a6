//! The robots that come with the program.

use std::path::Path;

use lifelike_character::Character;

use crate::error::RobotError;
use crate::profile::Profile;
use crate::robot::Robot;

/// Their names.
pub const NAMES: [&str; 2] = ["lima", "humanoid"];

/// MJCF and profile of a built-in robot.
fn texts(name: &str) -> Option<(&'static str, &'static str)> {
    match name {
        "lima" => Some((include_str!("../../../robots/lima.xml"), include_str!("../../../robots/lima.toml"))),
        "humanoid" => {
            Some((include_str!("../../../robots/humanoid.xml"), include_str!("../../../robots/humanoid.toml")))
        }
        _ => None,
    }
}

/// The built-in robot of this name, if there is one. The texts are part of the program, so a test makes sure that they
/// are read without error.
pub fn robot(name: &str) -> Option<Result<Robot, RobotError>> {
    let (mjcf, profile) = texts(name)?;
    let read = || {
        let character = Character::from_mjcf(mjcf, &format!("robots/{name}.xml"), None)?;
        let profile = Profile::from_toml(profile, Path::new(&format!("robots/{name}.toml")))?;
        Robot::from_character(character, profile)
    };
    Some(read())
}
