//! What of a robot the engine leaves out.

use lifelike_character::{Geom, GeomShape, JointKind};
use lifelike_robot::Robot;

/// What of a robot this engine does not simulate, a line each.
pub fn unsupported(robot: &Robot) -> Vec<String> {
    let mut lines = Vec::new();
    let character = &robot.character;
    let solid = |g: &&Geom| g.body != 0 && (g.contype != 0 || g.conaffinity != 0);
    let own: Vec<_> = character.geoms.iter().filter(solid).collect();
    for geom in &own {
        if !matches!(geom.shape, GeomShape::Sphere(_) | GeomShape::Capsule(..) | GeomShape::Box(_)) {
            lines.push(format!("geom '{}': its shape does not touch the ground", geom.name));
        }
        if geom.condim > 3 {
            lines.push(format!("geom '{}': no torsional or rolling friction", geom.name));
        }
    }
    for joint in character.joints.iter().filter(|j| j.kind == JointKind::Ball && j.range.is_some()) {
        lines.push(format!("joint '{}': a ball turns without limit", joint.name));
    }
    // MuJoCo's filter: parent and child never meet, nor do excluded pairs.
    let related = |a: usize, b: usize| a == b || character.bodies[a].parent == b || character.bodies[b].parent == a;
    let excluded = |a, b| character.excludes.contains(&(a, b)) || character.excludes.contains(&(b, a));
    let masks = |a: &Geom, b: &Geom| a.contype & b.conaffinity != 0 || b.contype & a.conaffinity != 0;
    let pairs = own.iter().enumerate().flat_map(|(i, a)| own[i + 1..].iter().map(move |b| (*a, *b)));
    let meet = pairs.filter(|(a, b)| masks(a, b) && !related(a.body, b.body) && !excluded(a.body, b.body)).count();
    if meet > 0 {
        lines.push(format!("{meet} pairs of its own geoms: parts of the robot pass through each other"));
    }
    lines
}
