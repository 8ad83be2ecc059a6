//! BONES-SEED's CSV of the G1: names of columns, centimetres, degrees, extrinsic XYZ angles, 120 frames per second.

use lifelike_character::{Quat, Vec3};

use super::table;
use super::{Content, Context, Fit, Layout, Part, Rate, RobotMotion, container, unfit};
use crate::clip::MotionClip;
use crate::error::MotionError;

/// Columns of the root, after the frame's number.
const ROOT: [&str; 6] =
    ["root_translateX", "root_translateY", "root_translateZ", "root_rotateX", "root_rotateY", "root_rotateZ"];
/// Column of the frame's number.
const FRAME: &str = "Frame";
/// Frames per second, one row each.
const RATE: f64 = 120.0;
/// Ending of a joint's column.
const JOINT: &str = "_dof";
/// Centimetres in a metre.
const CM: f64 = 100.0;

pub(super) const BONES_SEED: Layout = Layout {
    name: "bones-seed",
    title: "BONES-SEED CSV",
    endings: &[".csv"],
    rate: Rate::Fixed(RATE),
    holds: &[Part::Names],
    needs_robot: false,
    fits: |content, _| Ok(if columns(content).is_some() { Fit::Yes } else { Fit::No }),
    read,
    write,
};

/// Returns whether a column is one that only this layout has.
pub(super) fn is_column(name: &str) -> bool {
    ROOT.contains(&name)
}

fn columns(content: &Content<'_>) -> Option<Vec<usize>> {
    let Content::Table(table) = content else { return None };
    ROOT.iter().map(|name| table.column(name)).collect()
}

fn read(content: &mut Content<'_>, context: &Context<'_>) -> Result<RobotMotion, MotionError> {
    let expected =
        || context.expected("columns root_translateX to root_rotateZ, and a column ending in _dof for each joint");
    let root = columns(content).ok_or_else(expected)?;
    let Content::Table(table) = content else { return Err(expected()) };
    let header = table.header.clone().unwrap_or_default();
    let joints: Vec<(usize, &str)> =
        header.iter().enumerate().filter_map(|(at, name)| Some((at, name.strip_suffix(JOINT)?))).collect();
    let is_known = |name: &String| name == FRAME || ROOT.contains(&name.as_str()) || name.ends_with(JOINT);
    let step = table.column(FRAME).map_or(Ok(1.0), |at| step(table.rows().map(|row| row[at]).collect()));
    let step = step.map_err(|got| container(context.file, format!("a column '{FRAME}' that rises evenly"), got))?;
    let rate = if step == 1.0 { None } else { Some(RATE / step) };
    let place = |row: &[f64]| Vec3::new(row[root[0]], row[root[1]], row[root[2]]) / CM;
    let turn = |row: &[f64]| {
        let [x, y, z] = [root[3], root[4], root[5]].map(|at| row[at].to_radians());
        Quat::from_euler_angles(x, y, z)
    };
    let mut orientation: Vec<Quat> = table.rows().map(turn).collect();
    super::quaternions::without_flips(&mut orientation);
    Ok(RobotMotion {
        fps: rate,
        left_out: header.iter().filter(|name| !is_known(name)).cloned().collect(),
        root_position: table.rows().map(place).collect(),
        root_orientation: orientation,
        joints: table.rows().flat_map(|row| joints.iter().map(|(at, _)| row[*at].to_radians())).collect(),
        joint_names: joints.iter().map(|(_, name)| (*name).to_owned()).collect(),
        said: format!("{} columns with names, cm, extrinsic XYZ angles in degrees", header.len()),
        ..RobotMotion::default()
    })
}

/// Returns by how much the frame's number rises from row to row, or the first row where it rises by another number.
fn step(frames: Vec<f64>) -> Result<f64, String> {
    let step = frames.windows(2).next().map_or(1.0, |pair| pair[1] - pair[0]);
    let odd = frames.windows(2).position(|pair| pair[1] - pair[0] != step || step <= 0.0);
    odd.map_or(Ok(step), |row| Err(format!("{} after {} in row {}", frames[row + 1], frames[row], row + 2)))
}

fn write(clip: &MotionClip, _: &Context<'_>) -> Result<Vec<u8>, MotionError> {
    let joints = clip.joint_names.iter().map(|name| format!("{name}{JOINT}"));
    let header: Vec<String> = [FRAME].into_iter().chain(ROOT).map(str::to_owned).chain(joints).collect();
    let rows = (0..clip.len()).map(|frame| {
        let place = clip.root_position[frame] * CM;
        let (x, y, z) = clip.root_orientation[frame].euler_angles();
        let degrees = [x, y, z].into_iter().chain(clip.joints_at(frame).iter().copied()).map(f64::to_degrees);
        [frame as f64, place.x, place.y, place.z].into_iter().chain(degrees).collect()
    });
    table::write(Some(&header), rows).map_err(|why| unfit(clip, why))
}
