//! A character's shapes, for the page.

use std::collections::BTreeMap;

use lifelike_character::rotation::to_wxyz;
use lifelike_character::{Character, GeomShape, Kinematics, Quat, Vec3};
use lifelike_motion::Skeleton;
use serde_json::{Value, json};

use super::surface::{pack, surfaces};

/// Returns bodies (the world left out) and their shapes as the page's renderer reads them.
pub fn character_json(character: &Character) -> Value {
    let mut geoms: Vec<Value> = Vec::new();
    let mut seen = vec![false; character.bodies.len()];
    let height = height(character);
    let surfaces = surfaces(character, height);
    for geom in character.geoms.iter().filter(|geom| geom.body != 0 && geom.rgba[3] > 0.0) {
        let GeomShape::Mesh(name) = &geom.shape else { continue };
        if surfaces.contains_key(name) {
            seen[geom.body] = true;
            let mut value = shape_json(geom.body, "mesh", &[], &geom.position, &geom.orientation, geom.rgba);
            value["mesh"] = json!(name);
            geoms.push(value);
        }
    }
    // Shapes that collide are hidden where there is a picture of the body.
    let pictured = seen.clone();
    for geom in &character.geoms {
        let Some((shape, size)) = shape_of(&geom.shape) else { continue };
        if geom.body == 0 || geom.rgba[3] <= 0.0 || (pictured[geom.body] && geom.collides()) {
            continue;
        }
        seen[geom.body] = true;
        geoms.push(shape_json(geom.body, shape, &size, &geom.position, &geom.orientation, geom.rgba));
    }
    // A body without a shape we can draw (none, or a mesh) is shown by a bone from its parent.
    for (i, body) in character.bodies.iter().enumerate().skip(1) {
        let length = body.position.norm();
        if seen[i] || body.parent == 0 || length < 1e-4 {
            continue;
        }
        let along = Quat::rotation_between(&Vec3::z(), &body.position)
            .unwrap_or_else(|| Quat::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI));
        let size = [(0.15 * length).clamp(0.008, 0.03), length / 2.0];
        let grey = [0.5, 0.5, 0.5, 1.0];
        geoms.push(shape_json(body.parent, "capsule", &size, &(body.position / 2.0), &along, grey));
    }
    let names: Vec<&str> = character.bodies.iter().skip(1).map(|b| b.name.as_str()).collect();
    let meshes: BTreeMap<&String, Value> = surfaces.iter().map(|(name, mesh)| (name, pack(mesh))).collect();
    json!({ "name": character.name, "bodies": names, "geoms": geoms, "height": height, "meshes": meshes })
}

/// Returns the shapes that a character touches the ground and itself with, like [`character_json`].
pub(super) fn contacts_json(character: &Character) -> Value {
    let height = height(character);
    let surfaces = surfaces(character, height);
    let solid = character.geoms.iter().filter(|g| g.body != 0 && g.collides());
    let geoms = solid.filter_map(|geom| {
        let draw =
            |shape, size: &[f64]| shape_json(geom.body, shape, size, &geom.position, &geom.orientation, geom.rgba);
        if let GeomShape::Mesh(name) = &geom.shape {
            let mut value = surfaces.contains_key(name).then(|| draw("mesh", &[]))?;
            value["mesh"] = json!(name);
            return Some(value);
        }
        shape_of(&geom.shape).map(|(shape, size)| draw(shape, &size))
    });
    let geoms: Vec<Value> = geoms.collect();
    let used = |name: &str| geoms.iter().any(|geom| geom["mesh"] == *name);
    let meshes: BTreeMap<&String, Value> =
        surfaces.iter().filter(|(name, _)| used(name)).map(|(name, mesh)| (name, pack(mesh))).collect();
    let names: Vec<&str> = character.bodies.iter().skip(1).map(|b| b.name.as_str()).collect();
    json!({ "name": character.name, "bodies": names, "geoms": geoms, "height": height, "meshes": meshes })
}

/// A captured skeleton as JSON: bones between joints, and a head.
pub(super) fn describe_skeleton(skeleton: &Skeleton) -> Value {
    let height = rest_height(skeleton);
    let bone = |parent: usize, offset: &Vec3| {
        let length = offset.norm();
        let along = Quat::rotation_between(&Vec3::z(), offset)
            .unwrap_or_else(|| Quat::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI));
        let size = [(0.14 * length).clamp(0.006 * height, 0.03 * height), length / 2.0];
        (length > 1e-3).then(|| shape_json(parent + 1, "capsule", &size, &(offset / 2.0), &along, [0.5, 0.5, 0.5, 1.0]))
    };
    let joints = skeleton.parents.iter().zip(&skeleton.offsets).filter_map(|(parent, offset)| bone((*parent)?, offset));
    let is_head = |joint: &usize| skeleton.names[*joint].to_lowercase().ends_with("head");
    let head = (0..skeleton.names.len()).find(is_head).map(|joint| {
        let middle = Vec3::new(0.01, 0.0, 0.06) * height;
        let size = [0.052, 0.042, 0.07].map(|half| half * height);
        shape_json(joint + 1, "ellipsoid", &size, &middle, &Quat::identity(), [0.5, 0.5, 0.5, 1.0])
    });
    let ends = skeleton.ends.iter().filter(|(joint, _)| !is_head(joint));
    let geoms: Vec<Value> = joints.chain(ends.filter_map(|(joint, offset)| bone(*joint, offset))).chain(head).collect();
    json!({ "name": "human", "bodies": skeleton.names, "geoms": geoms, "height": height, "meshes": {} })
}

/// Returns the height of a skeleton in its rest pose (m).
fn rest_height(skeleton: &Skeleton) -> f64 {
    let mut heights: Vec<f64> = Vec::with_capacity(skeleton.offsets.len());
    for (parent, offset) in skeleton.parents.iter().zip(&skeleton.offsets) {
        heights.push(parent.map_or(0.0, |parent| heights[parent] + offset.z));
    }
    let ends = skeleton.ends.iter().map(|(joint, offset)| heights[*joint] + offset.z);
    let (low, high) = heights
        .iter()
        .copied()
        .chain(ends)
        .fold((0.0, 0.0_f64), |(low, high): (f64, f64), z| (low.min(z), high.max(z)));
    (high - low).max(0.05)
}

fn shape_of(shape: &GeomShape) -> Option<(&'static str, Vec<f64>)> {
    match shape {
        GeomShape::Sphere(radius) => Some(("sphere", vec![*radius])),
        GeomShape::Capsule(radius, half) => Some(("capsule", vec![*radius, *half])),
        GeomShape::Cylinder(radius, half) => Some(("cylinder", vec![*radius, *half])),
        GeomShape::Box(half) => Some(("box", half.as_slice().to_vec())),
        GeomShape::Ellipsoid(half) => Some(("ellipsoid", half.as_slice().to_vec())),
        GeomShape::Plane | GeomShape::Mesh(_) | GeomShape::HeightField(_) => None,
    }
}

fn shape_json(body: usize, shape: &str, size: &[f64], position: &Vec3, orientation: &Quat, rgba: [f32; 4]) -> Value {
    let round = |v: &f64| (v * 1e5).round() / 1e5;
    json!({
        "body": body - 1,
        "shape": shape,
        "size": size.iter().map(round).collect::<Vec<_>>(),
        "position": position.iter().map(round).collect::<Vec<_>>(),
        "orientation": to_wxyz(orientation).iter().map(round).collect::<Vec<_>>(),
        "rgba": rgba.iter().map(|c| round(&f64::from(*c))).collect::<Vec<_>>(),
    })
}

/// Rough height in the pose of the text (m): what the camera steps back for.
fn height(character: &Character) -> f64 {
    let kinematics = Kinematics::new(character);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for body in 1..character.bodies.len() {
        let z = kinematics.body_position[body].z;
        (low, high) = (low.min(z), high.max(z));
    }
    for geom in character.geoms.iter().filter(|g| g.body != 0) {
        if let Some((_, size)) = shape_of(&geom.shape) {
            let z = kinematics.point(geom.body, &geom.position).z;
            let reach = size.iter().copied().fold(0.0, f64::max);
            (low, high) = (low.min(z - reach), high.max(z + reach));
        }
    }
    if high > low { (high - low).max(0.05) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_human_has_a_head_in_proportion() {
        let up = |z: f64| Vec3::new(0.0, 0.0, z);
        let skeleton = Skeleton {
            names: ["Hips", "Spine", "Head", "Foot"].map(String::from).to_vec(),
            parents: vec![None, Some(0), Some(1), Some(0)],
            offsets: vec![up(0.0), up(0.5), up(0.3), up(-0.9)],
            ends: vec![(2, up(0.2)), (3, up(-0.1))],
        };
        let human = describe_skeleton(&skeleton);
        // From the end of the foot at -1 m to that of the head at 1 m.
        assert_eq!(human["height"], 2.0);
        let shapes: Vec<&str> =
            human["geoms"].as_array().into_iter().flatten().filter_map(|g| g["shape"].as_str()).collect();
        // Spine, neck, leg and foot are bones; the head's own bone is inside of the head.
        assert_eq!(shapes, ["capsule", "capsule", "capsule", "capsule", "ellipsoid"]);
        let head = &human["geoms"][4];
        assert_eq!((head["body"].as_u64(), head["size"][2].as_f64()), (Some(2), Some(0.14)));
    }
}
