//! glTF of a robot in motion, as another reader sees it.

use gltf::animation::util::ReadOutputs;
use lifelike_character::{Kinematics, Quat, Vec3};
use nalgebra::{Isometry3, Quaternion, Translation3, Unit};

use super::super::robot_motion::{by_name, write};
use super::robot_motion::{clips, lima};
use crate::formats::raw::from_y_up_z_forward;

fn isometry(place: [f32; 3], [x, y, z, w]: [f32; 4]) -> Isometry3<f64> {
    let turn = Quaternion::new(w, x, y, z).cast::<f64>();
    Isometry3::from_parts(Translation3::from(Vec3::from(place.map(f64::from))), Unit::new_normalize(turn))
}

#[test]
fn a_glb_has_the_robots_bodies_where_its_kinematics_puts_them() {
    let robot = lima();
    let clip = &clips(&robot, &["walk"])[0];
    let bytes = write(clip, by_name("glb").unwrap(), Some(&robot)).unwrap();
    let file = gltf::Gltf::from_slice(&bytes).unwrap();
    let blob = file.blob.as_deref().unwrap();
    let animation = file.animations().next().unwrap();
    let nodes: Vec<gltf::Node<'_>> = file.nodes().collect();
    let mut parents = vec![None; nodes.len()];
    nodes.iter().for_each(|node| node.children().for_each(|child| parents[child.index()] = Some(node.index())));
    let mut kinematics = Kinematics::new(&robot);
    let (columns, mut q) = (clip.columns_for(&robot).unwrap(), robot.reference_position());
    let mut worst = 0.0_f64;
    for frame in (0..clip.len()).step_by(20) {
        let mut local: Vec<([f32; 3], [f32; 4])> = nodes
            .iter()
            .map(|node| {
                let (place, turn, _) = node.transform().decomposed();
                (place, turn)
            })
            .collect();
        for channel in animation.channels() {
            let reader = channel.reader(|_| Some(blob));
            let time = reader.read_inputs().unwrap().nth(frame).unwrap();
            assert!((f64::from(time) - frame as f64 / clip.fps).abs() < 1e-6);
            let own = &mut local[channel.target().node().index()];
            match reader.read_outputs().unwrap() {
                ReadOutputs::Translations(mut all) => own.0 = all.nth(frame).unwrap(),
                ReadOutputs::Rotations(all) => own.1 = all.into_f32().nth(frame).unwrap(),
                _ => panic!("neither places nor turns"),
            }
        }
        let world = |mut node: usize| {
            let mut pose = isometry(local[node].0, local[node].1);
            while let Some(parent) = parents[node] {
                pose = isometry(local[parent].0, local[parent].1) * pose;
                node = parent;
            }
            pose
        };
        clip.write_position(&robot, &columns, frame, &mut q);
        kinematics.update(&robot, &q);
        let turn: Quat = from_y_up_z_forward().inverse();
        for body in 1..robot.bodies.len() {
            // The first node turns to y up; lima's bodies come depth-first, as nodes do.
            let pose = world(body);
            worst = worst.max((pose.translation.vector - turn * kinematics.body_position[body]).norm());
            worst = worst.max(pose.rotation.angle_to(&(turn * kinematics.body_orientation[body])));
        }
    }
    println!("glTF: bodies within {worst:.1e} (m, rad)");
    assert!(worst < 1e-5, "{worst}");
    let triangles: usize = file
        .meshes()
        .flat_map(|mesh| mesh.primitives().collect::<Vec<_>>())
        .map(|primitive| primitive.indices().unwrap().count() / 3)
        .sum();
    assert!(triangles > 1000, "{triangles}");
}
