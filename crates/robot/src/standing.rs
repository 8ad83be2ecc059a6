//! Tests of a character's default pose: upright, on feet that can touch the ground.

use std::sync::Arc;

use lifelike_character::{Anatomy, Character, Fitted, Kinematics, Role, Vec3};

use crate::error::RobotError;
use crate::profile::Profile;

/// Returns the anatomy of a character that can stand: feet that are nothing but meshes get boxes. One that lies is told of.
pub(crate) fn standing(
    character: &mut Arc<Character>,
    profile: &Profile,
    notes: &mut Vec<String>,
) -> Result<Anatomy, RobotError> {
    let anatomy = Anatomy::guess(character, &profile.anatomy)?;
    let feet: Vec<usize> = anatomy.soles.values().map(|sole| sole.body).collect();
    if let Some(warning) = lying(character, &anatomy) {
        Arc::make_mut(character).warnings.push(warning);
    }
    if character.meshes.is_empty() {
        return Ok(anatomy);
    }
    for Fitted { geom, size, .. } in Arc::make_mut(character).fit_boxes(&feet) {
        let body = &character.bodies[character.geoms[geom].body].name;
        notes.push(format!(
            "mesh of '{body}' touches as the box around it, {:.3} x {:.3} x {:.3} m",
            size.x, size.y, size.z
        ));
    }
    Ok(Anatomy::guess(character, &profile.anatomy)?)
}

/// Says where the legs go if it is not down: files are written with other axes up, and nothing else tells.
fn lying(character: &Character, anatomy: &Anatomy) -> Option<String> {
    let kinematics = Kinematics::new(character);
    let at = |role: Role| anatomy.places.get(&role).map(|place| kinematics.point(place.body, &place.point));
    let legs = [(Role::LeftThigh, Role::LeftFoot), (Role::RightThigh, Role::RightFoot)];
    let down: Vec3 = legs.into_iter().filter_map(|(hip, ankle)| Some(at(ankle)? - at(hip)?)).sum();
    if down.z <= -0.5 * down.norm() {
        return None;
    }
    let axis = ["x", "y", "z"][down.iamax()];
    let sign = if down[down.iamax()] < 0.0 { "-" } else { "" };
    Some(format!(
        "its legs go along {sign}{axis}, not down, and z is up; if its file has another axis up, turn it: where y is up, by a link above its root with a \
         fixed joint of rpy=\"1.5708 0 0\" (URDF), or its root body by a quarter about x (MJCF)"
    ))
}
