//! holosoma's npz: joint_pos is root position, quaternion w x y z and joints; names of joints and bodies, the world
//! first.
//!
//! holosoma's own converter (0.1.0) turns the bodies' angular velocities once more by the root, and takes linear
//! velocities at the centres of mass. Files written here have those of the bodies' frames in the world, as the
//! arrays' names say.

use super::arrays::Kind;
use super::kinematics::{self, Bodies, Traversal};
use super::quaternions::Order;
use super::{Content, Context, Fit, Layout, Part, RobotMotion, mjlab, names_of, unfit, vectors};
use crate::clip::MotionClip;
use crate::error::MotionError;
use crate::formats::npz::{self, Written};

/// Numbers of the root's pose in `joint_pos`.
const ROOT: usize = 7;

pub(super) const HOLOSOMA: Layout = Layout {
    name: "holosoma",
    title: "holosoma npz",
    holds: &[Part::Names],
    fits: |content, _| Ok(if is_one(content) { Fit::Yes } else { Fit::No }),
    read,
    write,
    ..mjlab::MJLAB
};

fn is_one(content: &Content<'_>) -> bool {
    let Content::Arrays(arrays) = content else { return false };
    arrays.kind() == Kind::Npz && arrays.has_all(&["joint_pos", "joint_names", "body_names"])
}

fn read(content: &mut Content<'_>, context: &Context<'_>) -> Result<RobotMotion, MotionError> {
    let Content::Arrays(arrays) = content else { return Err(context.expected("a zip of arrays (.npz)")) };
    let joint_names = arrays.texts("joint_names")?;
    let shape = arrays.shape("joint_pos")?;
    let frames = match *shape.as_slice() {
        [frames, width] if width == ROOT + joint_names.len() => frames,
        _ => return Err(arrays.wrong_shape("joint_pos", &format!("[frames, {}]", ROOT + joint_names.len()), &shape)),
    };
    let rows = arrays.table("joint_pos", frames, ROOT + joint_names.len())?;
    let columns = |from: usize, to: usize| -> Vec<f64> {
        rows.chunks_exact(ROOT + joint_names.len()).flat_map(|row| row[from..to].iter().copied()).collect()
    };
    let left_out = [
        "object_pos_w",
        "object_quat_w",
        "object_lin_vel_w",
        "object_ang_vel_w",
        "body_pos_w",
        "body_quat_w",
        "joint_vel",
        "body_lin_vel_w",
        "body_ang_vel_w",
    ];
    let names = arrays.texts("body_names")?;
    let bodies = match arrays.has("body_pos_w") {
        true => Bodies::sampled(arrays, "body_pos_w", frames, Some(names))?,
        false => Bodies::default(),
    };
    Ok(RobotMotion {
        bodies,
        fps: if arrays.has("fps") { Some(arrays.number("fps")?) } else { None },
        root_position: vectors(&columns(0, 3)),
        root_orientation: Order::Wxyz.rotations(&columns(3, ROOT), context.file)?,
        joints: columns(ROOT, ROOT + joint_names.len()),
        said: format!("root and {} joints in joint_pos, quaternion w x y z, names", joint_names.len()),
        left_out: left_out.into_iter().filter(|name| arrays.has(name)).map(str::to_owned).collect(),
        joint_names,
        ..RobotMotion::default()
    })
}

fn write(clip: &MotionClip, context: &Context<'_>) -> Result<Vec<u8>, MotionError> {
    let Some(robot) = context.robot else { return Err(unfit(clip, "expected a robot (--robot), got none".to_owned())) };
    let bodies: Vec<usize> = [0].into_iter().chain(Traversal::DepthFirst.bodies(robot)).collect();
    let states = kinematics::states(clip, robot, &bodies)?;
    let (frames, joints) = (clip.len(), clip.joint_names.len());
    let (mut positions, mut velocities) = (Vec::new(), Vec::new());
    for frame in 0..frames {
        positions.extend(clip.root_position[frame].iter());
        positions.extend(Order::Wxyz.numbers(&clip.root_orientation[frame]));
        positions.extend(&states.joints[frame * joints..(frame + 1) * joints]);
        velocities.extend(states.root_linear[frame].iter().chain(states.root_angular[frame].iter()));
        velocities.extend(&states.joint_velocity[frame * joints..(frame + 1) * joints]);
    }
    let flat = |vectors: &[lifelike_character::Vec3]| -> Vec<f64> {
        vectors.iter().flat_map(|vector| vector.iter().copied()).collect()
    };
    let turns: Vec<f64> = states.orientation.iter().flat_map(|turn| Order::Wxyz.numbers(turn)).collect();
    let names: Vec<String> = bodies.iter().map(|body| robot.bodies[*body].name.clone()).collect();
    let shape = [frames, bodies.len(), 3];
    npz::npz(&[
        // Readers take whole rates.
        if clip.fps.fract() == 0.0 {
            Written::i64("fps", &[clip.fps as i64])
        } else {
            Written::f64("fps", &[1], &[clip.fps])
        },
        Written::f64("joint_pos", &[frames, ROOT + joints], &positions),
        Written::f64("joint_vel", &[frames, ROOT - 1 + joints], &velocities),
        Written::f64("body_pos_w", &shape, &flat(&states.position)),
        Written::f64("body_quat_w", &[frames, bodies.len(), 4], &turns),
        Written::f64("body_lin_vel_w", &shape, &flat(&states.linear)),
        Written::f64("body_ang_vel_w", &shape, &flat(&states.angular)),
        Written::texts("joint_names", &names_of(robot)),
        Written::texts("body_names", &names),
    ])
    .map_err(|error| unfit(clip, error.to_string()))
}
