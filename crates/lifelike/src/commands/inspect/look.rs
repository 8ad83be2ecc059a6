//! `lifelike inspect ROBOT --look`: a page on which a wrong guess is seen.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use lifelike_character::{Anatomy, Character, Role};
use lifelike_report::{Cell, Column, ReportBuilder, RobotLook, Table};
use lifelike_robot::{Robot, RobotError, Shapes};

use crate::error::CliError;

/// Writes the page of a robot, or of a character that is none; returns its path.
pub fn write(name: &str, folder: Option<&Path>) -> Result<PathBuf, CliError> {
    let (character, position, anatomy, verdict) = match Robot::load(name) {
        Ok(robot) => {
            let (position, verdict) = (robot.default_position(), robot.readiness(Shapes::Primitives).verdict());
            (robot.character, position, robot.anatomy, verdict)
        }
        Err(error @ RobotError::Unknown { .. }) => return Err(error.into()),
        Err(error) => {
            let character = Character::load(name).map_err(|_| CliError::from(error))?;
            let position = character.reference_position();
            (character.into(), position, nobody(), "cannot be controlled".to_string())
        }
    };
    let sides = sides(&character, &anatomy);
    let role = |body: usize| anatomy.places.iter().find(|(_, place)| place.body == body).map(|(role, _)| *role);
    let mut table = Table::new(
        "Bodies",
        vec![Column::text("body"), Column::text("parent"), Column::number("mass", "kg"), Column::text("role")],
    );
    for (i, body) in character.bodies.iter().enumerate().skip(1) {
        let role = role(i).map_or_else(String::new, lifelike_robot::robot::role_name);
        table.rows.push(vec![
            Cell::text(&body.name),
            Cell::text(&character.bodies[body.parent].name),
            Cell::number(body.inertial.mass, 4),
            Cell::text(role),
        ]);
    }
    let own = format!("{}-look", character.name.replace(|c: char| !c.is_alphanumeric() && c != '-', "_"));
    let folder = folder.map_or_else(|| PathBuf::from(own), Path::to_path_buf);
    std::fs::create_dir_all(&folder).map_err(CliError::write(&folder))?;
    let path = folder.join("report.html");
    ReportBuilder::new(&character.name)
        .subtitle(verdict)
        .fact("mass", format!("{:.3} kg", character.mass()))
        .fact("bodies", (character.bodies.len() - 1).to_string())
        .fact("joints", character.scalar_joints().count().to_string())
        .fact("joints that follow others", character.couplings.len().to_string())
        .robot(RobotLook { character: &character, position: &position, sides: &sides })
        .table(table)
        .write(&path)?;
    Ok(path)
}

/// Returns no role for any body.
fn nobody() -> Anatomy {
    Anatomy { places: BTreeMap::new(), soles: BTreeMap::new() }
}

/// Returns the side of each body: that of its role, or of the body that carries it.
fn sides(character: &Character, anatomy: &Anatomy) -> Vec<i8> {
    let mut sides = vec![0; character.bodies.len()];
    for (role, place) in &anatomy.places {
        sides[place.body] = match role {
            Role::LeftThigh | Role::LeftShank | Role::LeftFoot => 1,
            Role::LeftUpperArm | Role::LeftForearm | Role::LeftHand => 1,
            Role::RightThigh | Role::RightShank | Role::RightFoot => -1,
            Role::RightUpperArm | Role::RightForearm | Role::RightHand => -1,
            Role::Pelvis | Role::Chest | Role::Head => 0,
        };
    }
    for (i, body) in character.bodies.iter().enumerate().skip(1) {
        if sides[i] == 0 {
            sides[i] = sides[body.parent];
        }
    }
    sides
}
