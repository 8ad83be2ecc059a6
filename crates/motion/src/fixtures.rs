//! A character made by hand, for tests: a floating root with an arm that swings and slides.

use lifelike_character::model::{Body, Character, Geom, GeomShape, Inertial, Joint, JointKind};
use lifelike_character::{Quat, Vec3};

use crate::clip::{MotionClip, Provenance};

fn body(name: &str, parent: usize, position: Vec3, joints: std::ops::Range<usize>) -> Body {
    let inertial =
        Inertial { mass: 1.0, com: Vec3::zeros(), orientation: Quat::identity(), diagonal: Vec3::repeat(0.01) };
    Body { name: name.into(), parent, position, orientation: Quat::identity(), inertial, joints, gravcomp: 0.0 }
}

fn joint(name: &str, body: usize, kind: JointKind, axis: Vec3, q_index: usize, v_index: usize) -> Joint {
    Joint {
        name: name.into(),
        body,
        kind,
        position: Vec3::zeros(),
        axis,
        range: None,
        q_index,
        v_index,
        reference: 0.0,
        armature: 0.0,
        damping: 0.0,
        frictionloss: 0.0,
        stiffness: 0.0,
        spring_reference: 0.0,
        actuator_force_range: None,
        velocity_limit: None,
        coupling: None,
    }
}

/// Returns the world, root (free), arm at (0, 0, 0.1) with a hinge about y and a slide along z.
pub fn swing() -> Character {
    Character {
        name: "swing".into(),
        bodies: vec![
            body("world", 0, Vec3::zeros(), 0..0),
            body("root", 0, Vec3::z(), 0..1),
            body("arm", 1, Vec3::new(0.0, 0.0, 0.1), 1..3),
        ],
        joints: vec![
            joint("free", 1, JointKind::Free, Vec3::z(), 0, 0),
            joint("hinge", 2, JointKind::Hinge, Vec3::y(), 7, 6),
            joint("slide", 2, JointKind::Slide, Vec3::z(), 8, 7),
        ],
        nq: 9,
        nv: 8,
        gravity: Vec3::new(0.0, 0.0, -9.81),
        timestep: 0.005,
        ..Character::default()
    }
}

/// Returns a clip of [`swing`] at 50 Hz: root at rest in the origin, both joints (hinge, slide) as functions of time
/// (s).
pub fn clip(frames: usize, joints: impl Fn(f64) -> [f64; 2]) -> MotionClip {
    MotionClip {
        name: "test".into(),
        fps: 50.0,
        joint_names: vec!["hinge".into(), "slide".into()],
        root_position: vec![Vec3::zeros(); frames],
        root_orientation: vec![Quat::identity(); frames],
        joints: (0..frames).flat_map(|i| joints(i as f64 / 50.0)).collect(),
        contacts: None,
        cyclic: false,
        provenance: Provenance { character: "swing".into(), ..Provenance::default() },
    }
}

/// A cube of 0.2 m and 1 kg that may stand on the ground: world and arm of [`swing`] lose their mass.
pub fn cube() -> Character {
    let mut character = swing();
    for body in [0, 2] {
        character.bodies[body].inertial.mass = 0.0;
        character.bodies[body].inertial.diagonal = Vec3::zeros();
    }
    character.geoms.push(Geom {
        name: "cube".into(),
        body: 1,
        shape: GeomShape::Box(Vec3::repeat(0.1)),
        position: Vec3::zeros(),
        orientation: Quat::identity(),
        contype: 1,
        conaffinity: 1,
        condim: 3,
        friction: [0.8, 0.0, 0.0],
        solref: [0.02, 1.0],
        solimp: [0.9, 0.95, 0.001, 0.5, 2.0],
        margin: 0.0,
        gap: 0.0,
        priority: 0,
        rgba: [1.0; 4],
    });
    character
}
