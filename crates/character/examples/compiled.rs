//! Prints what each joint of robots is and carries, a line of JSON per file, for `peers/robots/same.py`.
//!
//!     cargo run --release -p lifelike-character --example compiled -- robots/lima.xml robot.urdf
//!
//! Lengths and directions are those of the root's frame in the reference position. What a joint carries is the sum of the bodies below
//! it, so it does not matter which fixed bodies a program joins into one.

use lifelike_character::inertia::parallel_axis;
use lifelike_character::{Character, JointKind, Kinematics, Mat3, Vec3};

fn main() {
    for file in std::env::args().skip(1) {
        let line = match Character::load(&file) {
            Ok(character) => format!("\"joints\": {{{}}}", joints(&character).join(", ")),
            Err(error) => format!("\"error\": {:?}", error.to_string()),
        };
        println!("{{\"file\": {file:?}, {line}}}");
    }
}

fn joints(character: &Character) -> Vec<String> {
    let kinematics = Kinematics::new(character);
    let root = character.root_body();
    let (origin, axes) = (kinematics.body_position[root], kinematics.body_orientation[root].inverse());
    let describe = |(j, joint): (usize, &lifelike_character::Joint)| {
        let (mass, com, inertia) = carried(character, &kinematics, joint.body);
        let turn = axes.to_rotation_matrix().into_inner();
        let inertia = turn * inertia * turn.transpose();
        let drive = character.drive(j);
        let torque = drive.as_ref().and_then(|drive| drive.torque);
        let fields = [
            ("range", joint.range.map_or(vec![], |(low, high)| vec![low, high])),
            ("axis", (axes * kinematics.joint_axis[j]).as_slice().to_vec()),
            ("anchor", (axes * (kinematics.joint_anchor[j] - origin)).as_slice().to_vec()),
            ("mass", vec![mass]),
            ("com", (axes * (com - origin)).as_slice().to_vec()),
            ("inertia", inertia.as_slice().to_vec()),
            ("gains", drive.map_or(vec![], |drive| vec![drive.stiffness, drive.damping])),
            ("torque", torque.map_or(vec![], |(low, high)| vec![low, high])),
            ("passive", vec![joint.armature, joint.damping, joint.frictionloss, joint.stiffness]),
        ];
        let fields = fields.map(|(name, values)| format!("\"{name}\": {values:?}"));
        format!("{:?}: {{{}}}", joint.name, fields.join(", "))
    };
    let is_scalar = |joint: &lifelike_character::Joint| matches!(joint.kind, JointKind::Hinge | JointKind::Slide);
    character.joints.iter().enumerate().filter(|(_, joint)| is_scalar(joint)).map(describe).collect()
}

/// Returns mass (kg), centre (m) and inertia about it (kg m²) of a body with all below it.
fn carried(character: &Character, kinematics: &Kinematics, body: usize) -> (f64, Vec3, Mat3) {
    let is_below = |mut b: usize| loop {
        match b {
            _ if b == body => return true,
            0 => return false,
            _ => b = character.bodies[b].parent,
        }
    };
    let parts: Vec<(f64, Vec3, Mat3)> = (1..character.bodies.len())
        .filter(|b| is_below(*b))
        .map(|b| {
            let (inertial, turn) = (&character.bodies[b].inertial, kinematics.body_orientation[b].to_rotation_matrix());
            let inertia = turn.matrix() * inertial.tensor() * turn.matrix().transpose();
            (inertial.mass, kinematics.point(b, &inertial.com), inertia)
        })
        .collect();
    let mass: f64 = parts.iter().map(|part| part.0).sum();
    let com = parts.iter().map(|(mass, com, _)| com * *mass).sum::<Vec3>() / mass.max(f64::MIN_POSITIVE);
    let inertia = parts.iter().map(|(mass, at, inertia)| inertia + parallel_axis(*mass, &(at - com))).sum();
    (mass, com, inertia)
}
