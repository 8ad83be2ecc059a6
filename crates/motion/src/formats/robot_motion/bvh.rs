//! BVH of a robot, for animation programs: a joint for each body, y up, centimetres. It is written only.
//!
//! The rest pose is the robot's reference pose, with every frame along the axes of the world.

use std::fmt::Write as _;

use lifelike_character::{Character, Kinematics, Quat, Vec3};

use super::{Fit, Layout, Rate, unfit};
use crate::clip::MotionClip;
use crate::error::MotionError;
use crate::formats::raw::from_y_up_z_forward;

/// Centimetres in a metre.
const CM: f64 = 100.0;
/// End of a body without children (m, down the vertical): a bone needs a length.
const END: Vec3 = Vec3::new(0.0, 0.0, -0.05);

/// The format.
pub(super) const BVH: Layout = Layout {
    name: "bvh",
    title: "BVH",
    endings: &[".bvh"],
    rate: Rate::Stated,
    holds: &[],
    needs_robot: true,
    fits: |_, _| Ok(Fit::No),
    read: |_, context| Err(context.expected("a layout of robot motion; `lifelike motion retarget` reads BVH")),
    write: |clip, context| match context.robot {
        Some(robot) => write(clip, robot),
        None => Err(unfit(clip, "expected a robot (--robot), got none".to_owned())),
    },
};

fn write(clip: &MotionClip, robot: &Character) -> Result<Vec<u8>, MotionError> {
    let columns = clip.columns_for(robot)?;
    let mut kinematics = Kinematics::new(robot);
    let rest = kinematics.clone();
    let root = robot.root_body();
    let order = depth_first(robot, root);
    let mut text = String::from("HIERARCHY\n");
    hierarchy(robot, &rest, &order, &mut text);
    // Writing to a string cannot fail.
    let _ = writeln!(text, "MOTION\nFrames: {}\nFrame Time: {}", clip.len(), 1.0 / clip.fps);
    let mut q = robot.reference_position();
    for frame in 0..clip.len() {
        clip.write_position(robot, &columns, frame, &mut q);
        kinematics.update(robot, &q);
        let place = turned(kinematics.body_position[root]) * CM;
        let _ = write!(text, "{} {} {}", place.x, place.y, place.z);
        for &body in &order {
            let since_rest = |body: usize| kinematics.body_orientation[body] * rest.body_orientation[body].inverse();
            let parent = if body == root { Quat::identity() } else { since_rest(robot.bodies[body].parent) };
            let basis = from_y_up_z_forward();
            let (x, y, z) = (basis.inverse() * parent.inverse() * since_rest(body) * basis).euler_angles();
            let _ = write!(text, " {} {} {}", z.to_degrees(), y.to_degrees(), x.to_degrees());
        }
        text.push('\n');
    }
    Ok(text.into_bytes())
}

/// Returns a vector of z up, x forward in y up, z forward.
fn turned(vector: Vec3) -> Vec3 {
    from_y_up_z_forward().inverse() * vector
}

/// Returns the root and all bodies below, each followed by its own.
pub(super) fn depth_first(robot: &Character, root: usize) -> Vec<usize> {
    let (mut order, mut open) = (Vec::new(), vec![root]);
    while let Some(body) = open.pop() {
        order.push(body);
        open.extend((1..robot.bodies.len()).rev().filter(|&child| child != root && robot.bodies[child].parent == body));
    }
    order
}

fn hierarchy(robot: &Character, rest: &Kinematics, order: &[usize], text: &mut String) {
    let mut open: Vec<usize> = Vec::new();
    for &body in order {
        let parent = robot.bodies[body].parent;
        while open.last().is_some_and(|last| *last != parent) {
            open.pop();
            let _ = writeln!(text, "{}}}", "\t".repeat(open.len()));
        }
        let (indent, name) = ("\t".repeat(open.len()), robot.bodies[body].name.replace(char::is_whitespace, "_"));
        let (word, offset, places) = match open.is_empty() {
            true => ("ROOT", Vec3::zeros(), "6 Xposition Yposition Zposition"),
            false => ("JOINT", rest.body_position[body] - rest.body_position[parent], "3"),
        };
        let offset = turned(offset) * CM;
        let _ = writeln!(
            text,
            "{indent}{word} {name}\n{indent}{{\n{indent}\tOFFSET {} {} {}",
            offset.x, offset.y, offset.z
        );
        let _ = writeln!(text, "{indent}\tCHANNELS {places} Zrotation Yrotation Xrotation");
        if !order.iter().any(|&child| child != body && robot.bodies[child].parent == body) {
            let end = turned(END) * CM;
            let _ =
                writeln!(text, "{indent}\tEnd Site\n{indent}\t{{\n{indent}\t\tOFFSET {} {} {}", end.x, end.y, end.z);
            let _ = writeln!(text, "{indent}\t}}");
        }
        open.push(body);
    }
    while open.pop().is_some() {
        let _ = writeln!(text, "{}}}", "\t".repeat(open.len()));
    }
}
