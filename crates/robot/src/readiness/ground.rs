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
    for geom in character.geoms.iter().filter(|g| g.body == 0) {
        match geom.shape {
            GeomShape::Plane => {
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
            _ => return Err(format!("'{}' is fixed to the world: this engine has the ground only", geom.name)),
        }
    }
    Ok(found)
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
