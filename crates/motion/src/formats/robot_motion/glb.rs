//! glTF (binary) of a robot in motion, for Blender, browsers and game engines: a node for each body. It is written only.
//!
//! Body frames are the robot's own, z up, below one node that turns them to glTF's y up. The robot's looks come along:
//! its meshes, or the shapes that it touches with where a body has none.

mod buffer;
mod shapes;

use lifelike_character::rotation::to_wxyz;
use lifelike_character::{Character, Kinematics, Quat, Vec3};
use serde_json::{Value, json};

use super::bvh::depth_first;
use super::{Fit, Layout, Rate, unfit};
use crate::clip::MotionClip;
use crate::error::MotionError;
use crate::formats::raw::from_y_up_z_forward;
use buffer::Buffer;

/// The format.
pub(super) const GLB: Layout = Layout {
    name: "glb",
    title: "glTF",
    endings: &[".glb"],
    rate: Rate::Stated,
    holds: &[],
    needs_robot: true,
    fits: |_, _| Ok(Fit::No),
    read: |_, context| Err(context.expected("a layout of robot motion; glTF is written only")),
    write: |clip, context| match context.robot {
        Some(robot) => write(clip, robot),
        None => Err(unfit(clip, "expected a robot (--robot), got none".to_owned())),
    },
};

fn write(clip: &MotionClip, robot: &Character) -> Result<Vec<u8>, MotionError> {
    let mut buffer = Buffer::default();
    let order = depth_first(robot, robot.root_body());
    let node = |body: usize| order.iter().position(|other| *other == body).map(|at| at + 1);
    let turn = from_y_up_z_forward().inverse();
    let mut nodes = vec![json!({ "name": robot.name, "rotation": xyzw(&turn), "children": [1] })];
    let mut materials: Vec<Value> = Vec::new();
    let (mut meshes, mut pictures) = (Vec::new(), Vec::new());
    for &body in &order {
        let own = &robot.bodies[body];
        let parents = order.iter().enumerate().filter(|(_, child)| robot.bodies[**child].parent == body);
        let mut children: Vec<usize> = parents.filter(|(_, child)| **child != body).map(|(at, _)| at + 1).collect();
        for geom in robot.geoms.iter().filter(|geom| geom.body == body && robot.is_drawn(geom)) {
            let Some(surface) = shapes::surface(robot, &geom.shape) else { continue };
            let material = json!({
                "pbrMetallicRoughness": {
                    "baseColorFactor": linear(geom.rgba), "metallicFactor": 0.0, "roughnessFactor": 0.6,
                },
                "doubleSided": true,
            });
            let at = materials.iter().position(|known| *known == material).unwrap_or_else(|| {
                materials.push(material);
                materials.len() - 1
            });
            let primitive = buffer.primitive(&surface, at);
            children.push(order.len() + 1 + pictures.len());
            pictures.push(json!({
                "name": geom.name, "mesh": meshes.len(),
                "translation": geom.position.as_slice(), "rotation": xyzw(&geom.orientation),
            }));
            meshes.push(json!({ "name": geom.name, "primitives": [primitive] }));
        }
        let mut value = json!({
            "name": own.name, "translation": own.position.as_slice(), "rotation": xyzw(&own.orientation),
        });
        if !children.is_empty() {
            value["children"] = json!(children);
        }
        nodes.push(value);
    }
    nodes.extend(pictures);
    let times: Vec<f32> = (0..clip.len()).map(|frame| (frame as f64 / clip.fps) as f32).collect();
    let times = buffer.times(&times);
    let (mut samplers, mut channels) = (Vec::new(), Vec::new());
    for (body, track) in tracks(clip, robot, &order)? {
        let (path, output) = match track {
            Track::Place(places) => ("translation", buffer.vectors(&places)),
            Track::Turn(turns) => ("rotation", buffer.vectors(&turns)),
        };
        channels.push(json!({ "sampler": samplers.len(), "target": { "node": node(body), "path": path } }));
        samplers.push(json!({ "input": times, "output": output, "interpolation": "LINEAR" }));
    }
    let mut document = json!({
        "asset": { "version": "2.0", "generator": concat!("lifelike ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "name": robot.name, "nodes": [0] }],
        "nodes": nodes,
        "animations": [{ "name": clip.name, "samplers": samplers, "channels": channels }],
    });
    // An empty list is no glTF.
    for (name, list) in [("meshes", meshes), ("materials", materials)] {
        if !list.is_empty() {
            document[name] = Value::Array(list);
        }
    }
    Ok(buffer.into_file(document))
}

/// Numbers of one body over time.
enum Track {
    /// Places in the parent (m).
    Place(Vec<[f32; 3]>),
    /// Turns in the parent, `xyzw`.
    Turn(Vec<[f32; 4]>),
}

/// Returns what changes over the clip: a turn for each body that turns, and places of those that are moved.
fn tracks(clip: &MotionClip, robot: &Character, order: &[usize]) -> Result<Vec<(usize, Track)>, MotionError> {
    let columns = clip.columns_for(robot)?;
    let mut kinematics = Kinematics::new(robot);
    let mut q = robot.reference_position();
    let mut places: Vec<Vec<[f32; 3]>> = vec![Vec::new(); order.len()];
    let mut turns: Vec<Vec<[f32; 4]>> = vec![Vec::new(); order.len()];
    for frame in 0..clip.len() {
        clip.write_position(robot, &columns, frame, &mut q);
        kinematics.update(robot, &q);
        for (at, &body) in order.iter().enumerate() {
            let parent = if at == 0 { 0 } else { robot.bodies[body].parent };
            let back = kinematics.body_orientation[parent].inverse();
            let place = back * (kinematics.body_position[body] - kinematics.body_position[parent]);
            let mut turn = xyzw(&(back * kinematics.body_orientation[body]));
            // Of the two signs that of the frame before, so that nothing turns the long way round.
            if turns[at].last().is_some_and(|last| last.iter().zip(&turn).map(|(a, b)| a * b).sum::<f32>() < 0.0) {
                turn = turn.map(|x| -x);
            }
            places[at].push(place.map(|x| x as f32).into());
            turns[at].push(turn);
        }
    }
    let moves = |body: usize| !robot.bodies[body].joints.is_empty();
    let mut tracks = Vec::new();
    for ((&body, places), turns) in order.iter().zip(places).zip(turns) {
        if moves(body) {
            let still = |place: &[f32; 3]| place.iter().zip(&places[0]).all(|(a, b)| (a - b).abs() < 1e-7);
            if !places.iter().all(still) || body == order[0] {
                tracks.push((body, Track::Place(places)));
            }
            tracks.push((body, Track::Turn(turns)));
        }
    }
    Ok(tracks)
}

fn xyzw(turn: &Quat) -> [f32; 4] {
    let [w, x, y, z] = to_wxyz(turn);
    [x, y, z, w].map(|x| x as f32)
}

/// Returns a colour of the screen in light.
fn linear(rgba: [f32; 4]) -> [f32; 4] {
    let [r, g, b, a] = rgba;
    let [r, g, b] = [r, g, b].map(|x| x.clamp(0.0, 1.0).powf(2.2));
    [r, g, b, a.clamp(0.0, 1.0)]
}

/// A surface: points (m), their normals (none: flat faces) and triangles.
#[derive(Debug, Default)]
struct Surface {
    points: Vec<Vec3>,
    normals: Vec<Vec3>,
    faces: Vec<[u32; 3]>,
}
