//! Properties of a robot that the engine does not simulate.

use lifelike_character::{GeomShape, JointKind};
use lifelike_robot::Robot;

use super::shapes::{collision_pairs, solid, touches_ground, touches_parts};

/// Returns the properties of a robot that this engine does not simulate, a line each.
pub fn unsupported(robot: &Robot) -> Vec<String> {
    let mut lines = Vec::new();
    let character = &robot.character;
    for geom in solid(character) {
        let pairs = || collision_pairs(character).into_iter().any(|(a, b)| a.name == geom.name || b.name == geom.name);
        if !touches_ground(geom) {
            lines.push(format!("geom '{}': its shape touches nothing", geom.name));
        } else if !touches_parts(geom) && pairs() {
            lines.push(format!("geom '{}': its shape touches the ground and no other parts", geom.name));
        }
        if geom.condim > 3 {
            lines.push(format!("geom '{}': no torsional or rolling friction", geom.name));
        }
    }
    for geom in character.geoms.iter().filter(|g| g.body == 0 && g.collides()) {
        match geom.shape {
            GeomShape::Mesh(_) => lines.push(format!("geom '{}': its shape touches nothing", geom.name)),
            GeomShape::Plane if geom.condim > 3 => {
                lines.push(format!("geom '{}': no torsional or rolling friction", geom.name));
            }
            _ => {}
        }
    }
    for joint in character.joints.iter().filter(|j| j.kind == JointKind::Ball && j.range.is_some()) {
        lines.push(format!("joint '{}': a ball turns without limit", joint.name));
    }
    lines
}
