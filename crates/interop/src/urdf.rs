//! A robot as URDF: the text that holosoma's reader computes the anchor's orientation with.

use std::fmt::Write as _;

use lifelike_character::{Character, JointKind, Quat, Vec3};

/// Returns links, joints and inertias; no shapes, which the readers of policies strip anyway.
///
/// A hinge away from its body's origin, and a body with several hinges, get links of their own.
pub(crate) fn urdf(character: &Character) -> String {
    let mut text = String::from("<?xml version=\"1.0\"?>\n");
    let _ = writeln!(text, "<robot name=\"{}\">", escaped(&character.name));
    for (i, body) in character.bodies.iter().enumerate().skip(1) {
        let inertial = &body.inertial;
        let [ixx, iyy, izz] = inertial.diagonal.into();
        let _ = writeln!(
            text,
            "  <link name=\"{}\"><inertial>{}<mass value=\"{}\"/><inertia ixx=\"{ixx}\" ixy=\"0\" ixz=\"0\" iyy=\"{iyy}\" \
             iyz=\"0\" izz=\"{izz}\"/></inertial></link>",
            escaped(&body.name),
            origin(&inertial.com, &inertial.orientation),
            inertial.mass,
        );
        if body.parent == 0 {
            continue;
        }
        let parent = &character.bodies[body.parent].name;
        let joints = &character.joints[body.joints.clone()];
        let mut from = parent.clone();
        let mut place = (body.position, body.orientation);
        for (number, joint) in joints.iter().enumerate() {
            let kind = match (joint.kind, joint.range) {
                (JointKind::Slide, _) => "prismatic",
                (_, Some(_)) => "revolute",
                (_, None) => "continuous",
            };
            let is_last = number + 1 == joints.len() && joint.position.norm() == 0.0;
            let to = if is_last { body.name.clone() } else { format!("{}_{}", body.name, joint.name) };
            if !is_last {
                let _ = writeln!(text, "  <link name=\"{}\"/>", escaped(&to));
            }
            let (low, high) = joint.range.unwrap_or((0.0, 0.0));
            let axis: [f64; 3] = joint.axis.into();
            let [x, y, z] = axis;
            let at = (place.0 + place.1 * joint.position, place.1);
            let _ = writeln!(
                text,
                "  <joint name=\"{}\" type=\"{kind}\">{}<parent link=\"{}\"/><child link=\"{}\"/><axis xyz=\"{x} {y} {z}\"/>\
                 <limit lower=\"{low}\" upper=\"{high}\" effort=\"0\" velocity=\"0\"/></joint>",
                escaped(&joint.name),
                origin(&at.0, &at.1),
                escaped(&from),
                escaped(&to),
            );
            (from, place) = (to, (-joint.position, Quat::identity()));
        }
        if from != body.name {
            let _ = writeln!(
                text,
                "  <joint name=\"fixed_{i}\" type=\"fixed\">{}<parent link=\"{}\"/><child link=\"{}\"/></joint>",
                origin(&place.0, &place.1),
                escaped(&from),
                escaped(&body.name),
            );
        }
    }
    text.push_str("</robot>\n");
    text
}

fn origin(position: &Vec3, orientation: &Quat) -> String {
    let (roll, pitch, yaw) = orientation.euler_angles();
    let [x, y, z]: [f64; 3] = (*position).into();
    format!("<origin xyz=\"{x} {y} {z}\" rpy=\"{roll} {pitch} {yaw}\"/>")
}

fn escaped(name: &str) -> String {
    name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
