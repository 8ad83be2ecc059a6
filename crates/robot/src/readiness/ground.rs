//! Ground of a model: one level plane, or none.

use lifelike_character::rotation::to_wxyz;
use lifelike_character::{Character, Geom, GeomShape};

use super::{Readiness, Severity, Shapes};

/// Returns the model's plane; `None` where the model has none.
///
/// # Errors
/// A sentence that names the geom of the world which is no level ground.
pub fn level_ground(character: &Character) -> Result<Option<&Geom>, String> {
    let mut found = None;
    for geom in character.geoms.iter().filter(|g| is_fixed(character, g.body)) {
        match geom.shape {
            GeomShape::Plane if geom.body == 0 => {
                let [w, x, y, _] = to_wxyz(&geom.orientation);
                if x.abs() + y.abs() > 1e-9 * w.abs().max(1.0) {
                    return Err(format!("the plane '{}' is not level: give the slope as terrain", geom.name));
                }
                if found.is_some() {
                    return Err(format!("'{}' is a second plane: this engine has one ground", geom.name));
                }
                found = Some(geom);
            }
            GeomShape::Mesh(_) => {}
            _ if !geom.collides() => {}
            _ => {
                let of = match geom.body {
                    0 => String::new(),
                    body => format!(" of '{}'", character.bodies[body].name),
                };
                return Err(format!("'{}'{of} is fixed to the world: this engine has the ground only", geom.name));
            }
        }
    }
    Ok(found)
}

/// Returns whether a body is the world, or hangs on it without a joint and is no part of the robot.
fn is_fixed(character: &Character, mut body: usize) -> bool {
    if body != 0 && character.is_own(body) {
        return false;
    }
    while body != 0 && character.joints.iter().all(|joint| joint.body != body) {
        body = character.bodies[body].parent;
    }
    body == 0
}

/// Adds ground that our engine refuses.
pub(super) fn check(character: &Character, shapes: Shapes, readiness: &mut Readiness) {
    if shapes == Shapes::All {
        return;
    }
    if let Err(problem) = level_ground(character) {
        let remedy = "leave one level plane in the world, or use --engine mujoco";
        readiness.add(Severity::CannotTrain, problem, remedy);
    }
}
