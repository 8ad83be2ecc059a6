//! Rows without names: root position, root quaternion, joints. Unitree's LAFAN1 has the quaternion as x y z w, kimodo
//! as w x y z.
//!
//! Norm and columns are the same, so the order is found from the motion ([`find_order`]).

use std::fmt::Write as _;

use lifelike_character::Vec3;

use super::quaternions::{Order, find_order};
use super::table::{self, Table};
use super::{Content, Context, Fit, Layout, Rate, RobotMotion, in_order, joint_names, unfit};
use crate::clip::MotionClip;
use crate::error::MotionError;

/// Columns before the joints.
const ROOT: usize = 7;

/// Unitree's LAFAN1, retargeted.
pub(super) const LAFAN1: Layout = Layout {
    name: "lafan1",
    title: "Unitree LAFAN1 CSV",
    endings: &[".csv"],
    rate: Rate::Fixed(30.0),
    holds: &[],
    needs_robot: false,
    fits: |content, context| fits(content, context, Order::Xyzw),
    read: |content, context| read(content, context, Order::Xyzw),
    write: |clip, context| write(clip, context, Order::Xyzw),
};

/// kimodo's motion of the G1.
pub(super) const KIMODO: Layout = Layout {
    name: "kimodo",
    title: "kimodo G1 CSV",
    fits: |content, context| fits(content, context, Order::Wxyz),
    read: |content, context| read(content, context, Order::Wxyz),
    write: |clip, context| write(clip, context, Order::Wxyz),
    ..LAFAN1
};

fn fits(content: &mut Content<'_>, context: &Context<'_>, order: Order) -> Result<Fit, MotionError> {
    let Content::Table(table) = content else { return Ok(Fit::No) };
    if table.header.is_some() || table.columns() <= ROOT || !table.rows().next().is_some_and(is_unit) {
        return Ok(Fit::No);
    }
    if let Some(row) = table.rows().position(|row| !is_unit(row)) {
        let why = || format!("no unit quaternion in columns 4 to 7 of row {}", row + 1);
        return Ok(if order == Order::Xyzw { Fit::Wrong(why()) } else { Fit::No });
    }
    let (xyzw, wxyz) = (motion(table, Order::Xyzw, context)?, motion(table, Order::Wxyz, context)?);
    Ok(match find_order(&xyzw, &wxyz, context) {
        Some(found) if found == order => Fit::Yes,
        Some(_) => Fit::No,
        None => Fit::Doubtful("the robot may be upright in both".to_owned()),
    })
}

fn is_unit(row: &[f64]) -> bool {
    (row[3..ROOT].iter().map(|c| c * c).sum::<f64>().sqrt() - 1.0).abs() < super::quaternions::NOT_UNIT
}

fn motion(table: &Table, order: Order, context: &Context<'_>) -> Result<RobotMotion, MotionError> {
    let columns = table.columns();
    let turns: Vec<f64> = table.rows().flat_map(|row| row[3..ROOT].iter().copied()).collect();
    Ok(RobotMotion {
        root_position: table.rows().map(|row| Vec3::new(row[0], row[1], row[2])).collect(),
        root_orientation: order.rotations(&turns, context.file)?,
        joints: table.rows().flat_map(|row| row[ROOT..].iter().copied()).collect(),
        joint_names: joint_names(columns - ROOT, context)?,
        ..RobotMotion::default()
    })
}

fn read(content: &mut Content<'_>, context: &Context<'_>, order: Order) -> Result<RobotMotion, MotionError> {
    let Content::Table(table) = content else { return Err(context.expected("a table of numbers")) };
    if table.header.is_some() || table.columns() <= ROOT {
        return Err(context.expected("rows of root position, quaternion and joints, without names"));
    }
    let mut said = String::new();
    let _ = write!(said, "{} columns, quaternion {}", table.columns(), order.words());
    Ok(RobotMotion { said, ..motion(table, order, context)? })
}

fn write(clip: &MotionClip, context: &Context<'_>, order: Order) -> Result<Vec<u8>, MotionError> {
    let columns = in_order(clip, context)?;
    let rows = (0..clip.len()).map(|frame| {
        let joints = clip.joints_at(frame);
        let root = clip.root_position[frame].iter().copied().chain(order.numbers(&clip.root_orientation[frame]));
        root.chain(columns.iter().map(|column| joints[*column])).collect()
    });
    table::write(None, rows).map_err(|why| unfit(clip, why))
}
