//! `motion.npz` of mjlab and BeyondMimic, and wbc-mjlab's bundles: joints, and poses and velocities of all bodies.
//!
//! mjlab and BeyondMimic have the same arrays without names. mjlab numbers bodies and joints depth-first, BeyondMimic
//! (Isaac Lab) breadth-first. The robot's forward kinematics tells which: only in the right order are the bodies
//! where the joints put them.

use super::arrays::{Arrays, Kind};
use super::kinematics::{self, Bodies, Sampled, Traversal};
use super::quaternions::Order;
use super::{Content, Context, Fit, Layout, Part, Rate, RobotMotion, g1_names, unfit, vectors};
use crate::clip::MotionClip;
use crate::error::MotionError;
use crate::formats::npz::{self, Written};

/// Mean distance (m) up to which bodies are where the joints put them: files have 32-bit numbers, models differ by
/// mm.
const NEAR: f64 = 0.01;
/// Arrays of poses.
const POSES: [&str; 3] = ["joint_pos", "body_pos_w", "body_quat_w"];

pub(super) const MJLAB: Layout = Layout {
    name: "mjlab",
    title: "mjlab motion.npz",
    endings: &[".npz"],
    rate: Rate::Usual(50.0),
    holds: &[],
    needs_robot: true,
    fits: |content, context| fits(content, context, Traversal::DepthFirst),
    read: |content, context| read_ordered(content, context, Traversal::DepthFirst),
    write: |clip, context| write_ordered(clip, context, Traversal::DepthFirst),
};

pub(super) const BEYONDMIMIC: Layout = Layout {
    name: "beyondmimic",
    title: "BeyondMimic motion.npz",
    fits: |content, context| fits(content, context, Traversal::BreadthFirst),
    read: |content, context| read_ordered(content, context, Traversal::BreadthFirst),
    write: |clip, context| write_ordered(clip, context, Traversal::BreadthFirst),
    ..MJLAB
};

pub(super) const WBC: Layout = Layout {
    name: "wbc",
    title: "wbc-mjlab bundle",
    holds: &[Part::Names],
    fits: |content, _| Ok(if is_wbc(content) { Fit::Yes } else { Fit::No }),
    read: read_wbc,
    write: write_wbc,
    ..MJLAB
};

fn is_wbc(content: &Content<'_>) -> bool {
    let Content::Arrays(arrays) = content else { return false };
    arrays.kind() == Kind::Npz && arrays.has_all(&POSES) && arrays.has("joint_names") && !arrays.has("body_names")
}

fn fits(content: &mut Content<'_>, context: &Context<'_>, order: Traversal) -> Result<Fit, MotionError> {
    let Content::Arrays(arrays) = content else { return Ok(Fit::No) };
    if arrays.kind() != Kind::Npz || !arrays.has_all(&POSES) || arrays.has("joint_names") {
        return Ok(Fit::No);
    }
    let all = [Traversal::DepthFirst, Traversal::BreadthFirst];
    let [depth, breadth] = distances(arrays, context, all)?;
    let (Some(depth), Some(breadth)) = (depth, breadth) else {
        let joints = arrays.shape("joint_pos")?.get(1).copied().unwrap_or(0);
        super::joint_names(joints, context)?;
        let bodies = arrays.shape("body_pos_w")?.get(1).copied().unwrap_or(0);
        let other = context.robot.filter(|robot| robot.bodies.len() != bodies + 1);
        let of = other.map(|robot| format!("; {} has {} bodies", robot.name, robot.bodies.len() - 1));
        return Ok(Fit::Doubtful(format!("{bodies} bodies{}", of.unwrap_or_default())));
    };
    let (mine, other) = if order == all[0] { (depth, breadth) } else { (breadth, depth) };
    Ok(match (mine < NEAR, other < NEAR) {
        // A robot whose orders are the same: MuJoCo's is as good as the other.
        (true, true) if order == all[0] => Fit::Yes,
        (true, true) | (false, true) => Fit::No,
        (true, false) => Fit::Yes,
        (false, false) => Fit::Wrong(format!(
            "{}: bodies are {:.2} m from where the joints of {} put them; --robot names another robot",
            order.words(),
            mine,
            context.robot.map_or("no robot", |robot| robot.name.as_str())
        )),
    })
}

/// Returns the mean distances of bodies from forward kinematics (m), in each order.
fn distances(
    arrays: &mut Arrays<'_>,
    context: &Context<'_>,
    orders: [Traversal; 2],
) -> Result<[Option<f64>; 2], MotionError> {
    let shape = arrays.shape("joint_pos")?;
    let is_sample = kinematics::is_sample(shape.first().copied().unwrap_or(0));
    let joints = arrays.select("joint_pos", |row, _| is_sample(row))?;
    let bodies = vectors(&arrays.select("body_pos_w", |row, _| is_sample(row))?);
    let turns = arrays.select("body_quat_w", |row, column| is_sample(row) && column < 4)?;
    let root_orientation = Order::Wxyz.rotations(&turns, context.file)?;
    let sampled = Sampled { joints: &joints, bodies: &bodies, root_orientation: &root_orientation };
    Ok(orders.map(|order| kinematics::distance(&sampled, context, order)))
}

fn read_ordered(
    content: &mut Content<'_>,
    context: &Context<'_>,
    order: Traversal,
) -> Result<RobotMotion, MotionError> {
    let Content::Arrays(arrays) = content else { return Err(context.expected("a zip of arrays (.npz)")) };
    let mut motion = read(arrays, context, 0)?;
    let joints = arrays.shape("joint_pos")?.get(1).copied().unwrap_or(0);
    motion.joint_names = match context.robot.filter(|robot| robot.scalar_joints().count() == joints) {
        Some(robot) => order.joints(robot),
        None if joints == g1_names().len() => g1_order(order),
        None => super::joint_names(joints, context)?,
    };
    motion.said = format!("{}, {}", motion.said, order.words());
    Ok(motion)
}

/// Returns the names of the G1's joints in an order: legs and waist hang on the pelvis, arms on the waist.
fn g1_order(order: Traversal) -> Vec<String> {
    let mut joints: Vec<(usize, String)> =
        (1..=6).chain(1..=6).chain(1..=3).chain(4..=10).chain(4..=10).zip(g1_names()).collect();
    if order == Traversal::BreadthFirst {
        joints.sort_by_key(|(depth, _)| *depth);
    }
    joints.into_iter().map(|(_, name)| name).collect()
}

/// Reads joints, and the root's pose from its body.
pub(super) fn read(arrays: &mut Arrays<'_>, context: &Context<'_>, root: usize) -> Result<RobotMotion, MotionError> {
    let shape = arrays.shape("joint_pos")?;
    let &[frames, joints] = shape.as_slice() else {
        return Err(arrays.wrong_shape("joint_pos", "[frames, joints]", &shape));
    };
    let bodies = match *arrays.shape("body_pos_w")?.as_slice() {
        [rows, bodies, 3] if rows == frames && bodies > root => bodies,
        ref other => return Err(arrays.wrong_shape("body_pos_w", &format!("[{frames}, bodies, 3]"), other)),
    };
    let turned = arrays.shape("body_quat_w")?;
    if turned != [frames, bodies, 4] {
        return Err(arrays.wrong_shape("body_quat_w", &format!("[{frames}, {bodies}, 4]"), &turned));
    }
    let of_root = |column: usize, width: usize| (root * width..(root + 1) * width).contains(&column);
    let places = arrays.select("body_pos_w", |_, column| of_root(column, 3))?;
    if places.iter().all(|place| *place == 0.0) {
        let got = "a body at the origin in all frames (the world?)".to_owned();
        return Err(super::container(context.file, "the robot's root as the first body of body_pos_w".to_owned(), got));
    }
    let turns = arrays.select("body_quat_w", |_, column| of_root(column, 4))?;
    Ok(RobotMotion {
        fps: if arrays.has("fps") { Some(arrays.number("fps")?) } else { None },
        root_position: vectors(&places),
        root_orientation: Order::Wxyz.rotations(&turns, context.file)?,
        joints: arrays.table("joint_pos", frames, joints)?,
        bodies: Bodies::sampled(arrays, "body_pos_w", frames, None)?,
        said: format!("{joints} joints, {bodies} bodies, quaternion w x y z"),
        left_out: ["body_pos_w", "body_quat_w", "joint_vel", "body_lin_vel_w", "body_ang_vel_w"]
            .into_iter()
            .filter(|name| arrays.has(name))
            .map(str::to_owned)
            .collect(),
        ..RobotMotion::default()
    })
}

fn read_wbc(content: &mut Content<'_>, context: &Context<'_>) -> Result<RobotMotion, MotionError> {
    let Content::Arrays(arrays) = content else { return Err(context.expected("a zip of arrays (.npz)")) };
    let mut motion = read(arrays, context, 0)?;
    motion.joint_names = arrays.texts("joint_names")?;
    if arrays.has("robot") {
        motion.robot = arrays.texts("robot")?.into_iter().next().unwrap_or_default();
    }
    if arrays.has("segment_start_idx") {
        motion.segments = segments(arrays, context)?;
        let used = motion.segments.iter().map(|(_, _, frames)| frames).fold(0, |sum: usize, n| sum.saturating_add(*n));
        if let Some(unused) = motion.root_position.len().checked_sub(used).filter(|unused| *unused > 0) {
            motion.left_out.push(format!("{unused} frames that are in no segment"));
        }
    }
    let clips = motion.segments.len().max(1);
    motion.said = format!("{}, names of joints, {clips} clip{}", motion.said, if clips == 1 { "" } else { "s" });
    Ok(motion)
}

fn segments(arrays: &mut Arrays<'_>, context: &Context<'_>) -> Result<Vec<(String, usize, usize)>, MotionError> {
    let sizes = |numbers: Vec<f64>| -> Option<Vec<usize>> {
        numbers.into_iter().map(|n| (n >= 0.0 && n.fract() == 0.0).then_some(n as usize)).collect()
    };
    let starts = sizes(arrays.select("segment_start_idx", |_, _| true)?);
    let lengths = sizes(arrays.select("segment_length", |_, _| true)?);
    let expected = || context.expected("segment_start_idx and segment_length of whole numbers, one for each segment");
    let (Some(starts), Some(lengths)) = (starts, lengths) else { return Err(expected()) };
    if starts.len() != lengths.len() {
        return Err(expected());
    }
    let mut names = if arrays.has("segment_names") { arrays.texts("segment_names")? } else { Vec::new() };
    let stem = crate::formats::clip_name(context.file);
    names.extend((names.len()..starts.len()).map(|at| format!("{stem}_{at}")));
    Ok(names.into_iter().zip(starts).zip(lengths).map(|((name, start), length)| (name, start, length)).collect())
}

/// Returns the arrays of a clip, bodies and joints in this order.
fn arrays_of(clip: &MotionClip, context: &Context<'_>, order: Traversal) -> Result<Vec<Written>, MotionError> {
    let Some(robot) = context.robot else { return Err(unfit(clip, "expected a robot (--robot), got none".to_owned())) };
    let bodies = order.bodies(robot);
    let states = kinematics::states(clip, robot, &bodies)?;
    let (frames, joints) = (clip.len(), clip.joint_names.len());
    let names = super::names_of(robot);
    let columns: Vec<usize> =
        order.joints(robot).iter().filter_map(|name| names.iter().position(|other| other == name)).collect();
    let ordered = |values: &[f64]| -> Vec<f64> {
        values.chunks_exact(joints.max(1)).flat_map(|row| columns.iter().map(|column| row[*column])).collect()
    };
    let flat = |vectors: &[lifelike_character::Vec3]| -> Vec<f64> {
        vectors.iter().flat_map(|vector| vector.iter().copied()).collect()
    };
    let turns: Vec<f64> = states.orientation.iter().flat_map(|turn| Order::Wxyz.numbers(turn)).collect();
    let shape = [frames, bodies.len(), 3];
    Ok(vec![
        Written::f32("joint_pos", &[frames, joints], &ordered(&states.joints)),
        Written::f32("joint_vel", &[frames, joints], &ordered(&states.joint_velocity)),
        Written::f32("body_pos_w", &shape, &flat(&states.position)),
        Written::f32("body_quat_w", &[frames, bodies.len(), 4], &turns),
        Written::f32("body_lin_vel_w", &shape, &flat(&states.linear)),
        Written::f32("body_ang_vel_w", &shape, &flat(&states.angular)),
    ])
}

fn write_ordered(clip: &MotionClip, context: &Context<'_>, order: Traversal) -> Result<Vec<u8>, MotionError> {
    let mut arrays = arrays_of(clip, context, order)?;
    arrays.insert(0, Written::f64("fps", &[1], &[clip.fps]));
    npz::npz(&arrays).map_err(|error| unfit(clip, error.to_string()))
}

fn write_wbc(clip: &MotionClip, context: &Context<'_>) -> Result<Vec<u8>, MotionError> {
    let mut arrays = arrays_of(clip, context, Traversal::DepthFirst)?;
    let names = context.robot.map(super::names_of).unwrap_or_default();
    arrays.extend([
        Written::f32("fps", &[1], &[clip.fps]),
        Written::texts("joint_names", &names),
        Written::texts("robot", std::slice::from_ref(&clip.provenance.character)),
        Written::i64("segment_start_idx", &[0]),
        Written::i64("segment_length", &[clip.len() as i64]),
        Written::texts("segment_names", std::slice::from_ref(&clip.name)),
    ]);
    npz::npz(&arrays).map_err(|error| unfit(clip, error.to_string()))
}
