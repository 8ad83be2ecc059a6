//! GMR's pickled dict: rate, root, joints in the order of the robot's model.

use super::arrays::Kind;
use super::encode::{self, Entry};
use super::quaternions::{Order, find_order};
use super::{Content, Context, Fit, Layout, Part, Rate, RobotMotion, in_order, joint_names, vectors};
use crate::clip::MotionClip;
use crate::error::MotionError;
use crate::formats::npz::Written;

/// Entries that every reader of GMR's files asks for.
const REQUIRED: [&str; 3] = ["root_pos", "root_rot", "dof_pos"];
/// Entries under which names of joints are found.
const NAMES: [&str; 3] = ["dof_joint_names", "joint_names", "joint_order"];

pub(super) const GMR: Layout = Layout {
    name: "gmr",
    title: "GMR pickle",
    endings: &[".pkl"],
    rate: Rate::Stated,
    holds: &[Part::Names],
    needs_robot: false,
    fits,
    read,
    write,
};

fn fits(content: &mut Content<'_>, context: &Context<'_>) -> Result<Fit, MotionError> {
    let Content::Arrays(arrays) = content else { return Ok(Fit::No) };
    if arrays.kind() != Kind::Pickle || !arrays.has_all(&REQUIRED) {
        return Ok(Fit::No);
    }
    let readings = [Order::Xyzw, Order::Wxyz].map(|order| motion(content, context, order));
    let [Ok(xyzw), Ok(wxyz)] = readings else { return Ok(Fit::Yes) };
    Ok(match find_order(&xyzw, &wxyz, context) {
        Some(Order::Wxyz) => Fit::Wrong(
            "root_rot is upright as w x y z, but GMR writes x y z w; --layout gmr reads it as GMR does".to_owned(),
        ),
        _ => Fit::Yes,
    })
}

fn motion(content: &mut Content<'_>, context: &Context<'_>, order: Order) -> Result<RobotMotion, MotionError> {
    let Content::Arrays(arrays) = content else { return Err(context.expected("a pickled dict")) };
    let shape = arrays.shape("dof_pos")?;
    let &[frames, joints] = shape.as_slice() else {
        return Err(arrays.wrong_shape("dof_pos", "[frames, joints]", &shape));
    };
    let turns = arrays.table("root_rot", frames, 4)?;
    let names = NAMES.iter().find(|name| arrays.has(name)).map(|name| arrays.texts(name)).transpose()?;
    Ok(RobotMotion {
        fps: if arrays.has("fps") { Some(arrays.number("fps")?) } else { None },
        root_position: vectors(&arrays.table("root_pos", frames, 3)?),
        root_orientation: order.rotations(&turns, context.file)?,
        joints: arrays.table("dof_pos", frames, joints)?,
        joint_names: names.map_or_else(|| joint_names(joints, context), Ok)?,
        said: format!("{joints} joints, quaternion {}", order.words()),
        ..RobotMotion::default()
    })
}

fn read(content: &mut Content<'_>, context: &Context<'_>) -> Result<RobotMotion, MotionError> {
    motion(content, context, Order::Xyzw)
}

fn write(clip: &MotionClip, context: &Context<'_>) -> Result<Vec<u8>, MotionError> {
    // Without a robot the names say the order.
    let columns = in_order(clip, context).or_else(|error| match context.robot {
        Some(_) => Err(error),
        None => Ok((0..clip.joint_names.len()).collect()),
    })?;
    let names: Vec<String> = columns.iter().map(|column| clip.joint_names[*column].clone()).collect();
    let places: Vec<f64> = clip.root_position.iter().flat_map(|place| place.iter().copied()).collect();
    let turns: Vec<f64> = clip.root_orientation.iter().flat_map(|turn| Order::Xyzw.numbers(turn)).collect();
    let joints: Vec<f64> =
        (0..clip.len()).flat_map(|frame| columns.iter().map(move |column| clip.joints_at(frame)[*column])).collect();
    let frames = clip.len();
    Ok(encode::pickle(&[
        ("fps", Entry::Float(clip.fps)),
        ("root_pos", Entry::Array(Written::f64("root_pos", &[frames, 3], &places))),
        ("root_rot", Entry::Array(Written::f64("root_rot", &[frames, 4], &turns))),
        ("dof_pos", Entry::Array(Written::f64("dof_pos", &[frames, names.len()], &joints))),
        ("local_body_pos", Entry::None),
        ("link_body_list", Entry::None),
        ("joint_names", Entry::Texts(&names)),
    ]))
}
