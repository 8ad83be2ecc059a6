//! What of a robot the engine leaves out.

use lifelike_character::{GeomShape, JointKind};
use lifelike_robot::Robot;

use super::shapes::solid;

/// What of a robot this engine does not simulate, a line each.
pub fn unsupported(robot: &Robot) -> Vec<String> {
    let mut lines = Vec::new();
    let character = &robot.character;
    for geom in solid(character) {
        if !matches!(geom.shape, GeomShape::Sphere(_) | GeomShape::Capsule(..) | GeomShape::Box(_)) {
            lines.push(format!("geom '{}': its shape touches nothing", geom.name));
        }
        if geom.condim > 3 {
            lines.push(format!("geom '{}': no torsional or rolling friction", geom.name));
        }
    }
    for joint in character.joints.iter().filter(|j| j.kind == JointKind::Ball && j.range.is_some()) {
        lines.push(format!("joint '{}': a ball turns without limit", joint.name));
    }
    lines
}
