//! ProtoMotions' `.motion`: a dict of tensors by `torch.save`, bodies and joints in the order of the model,
//! quaternions x y z w.

use super::arrays::Kind;
use super::encode::{self, Entry};
use super::kinematics::{self, Bodies, Traversal};
use super::quaternions::Order;
use super::{Content, Context, Fit, Layout, Part, Rate, RobotMotion, joint_names, unfit, vectors};
use crate::clip::{Contacts, MotionClip};
use crate::error::MotionError;
use crate::formats::npz::Written;

/// Tensors that every file has.
const REQUIRED: [&str; 3] = ["dof_pos", "rigid_body_pos", "rigid_body_rot"];
/// Tensor of contacts, a flag for each body.
const CONTACTS: &str = "rigid_body_contacts";

pub(super) const PROTOMOTIONS: Layout = Layout {
    name: "protomotions",
    title: "ProtoMotions .motion",
    endings: &[".motion"],
    rate: Rate::Stated,
    holds: &[Part::Contacts],
    needs_robot: true,
    fits: |content, _| Ok(if is_one(content) { Fit::Yes } else { Fit::No }),
    read,
    write,
};

fn is_one(content: &Content<'_>) -> bool {
    matches!(content, Content::Arrays(arrays) if arrays.kind() == Kind::Torch && arrays.has_all(&REQUIRED))
}

fn read(content: &mut Content<'_>, context: &Context<'_>) -> Result<RobotMotion, MotionError> {
    let Content::Arrays(arrays) = content else { return Err(context.expected("a dict by torch.save")) };
    let shape = arrays.shape("dof_pos")?;
    let &[frames, joints] = shape.as_slice() else {
        return Err(arrays.wrong_shape("dof_pos", "[frames, joints]", &shape));
    };
    let bodies = match *arrays.shape("rigid_body_pos")?.as_slice() {
        [rows, bodies, 3] if rows == frames && bodies > 0 => bodies,
        ref other => return Err(arrays.wrong_shape("rigid_body_pos", &format!("[{frames}, bodies, 3]"), other)),
    };
    let turned = arrays.shape("rigid_body_rot")?;
    if turned != [frames, bodies, 4] {
        return Err(arrays.wrong_shape("rigid_body_rot", &format!("[{frames}, {bodies}, 4]"), &turned));
    }
    let turns = arrays.select("rigid_body_rot", |_, column| column < 4)?;
    let contacts = match context.robot.filter(|robot| arrays.has(CONTACTS) && robot.bodies.len() == bodies + 1) {
        Some(robot) => {
            let flags = arrays.table(CONTACTS, frames, bodies)?;
            contacts_of(&flags, robot.bodies[1..].iter().map(|body| body.name.clone()).collect())
        }
        None => None,
    };
    let left_out = ["rigid_body_pos", "rigid_body_rot", "dof_vel", "rigid_body_vel", "rigid_body_ang_vel", CONTACTS];
    let is_left_out = |name: &&str| arrays.has(name) && (*name != CONTACTS || contacts.is_none());
    Ok(RobotMotion {
        left_out: left_out.into_iter().filter(is_left_out).map(str::to_owned).collect(),
        fps: if arrays.has("fps") { Some(arrays.number("fps")?) } else { None },
        root_position: vectors(&arrays.select("rigid_body_pos", |_, column| column < 3)?),
        root_orientation: Order::Xyzw.rotations(&turns, context.file)?,
        joints: arrays.table("dof_pos", frames, joints)?,
        bodies: Bodies::sampled(arrays, "rigid_body_pos", frames, None)?,
        joint_names: joint_names(joints, context)?,
        said: format!("{joints} joints, {bodies} bodies, quaternion x y z w"),
        contacts,
        ..RobotMotion::default()
    })
}

/// Returns the contacts of the bodies that ever touch: none where no body does.
fn contacts_of(flags: &[f64], names: Vec<String>) -> Option<Contacts> {
    let bodies = names.len();
    let touching: Vec<usize> =
        (0..bodies).filter(|body| flags.iter().skip(*body).step_by(bodies).any(|f| *f > 0.5)).collect();
    let rows = flags.chunks_exact(bodies.max(1));
    (!touching.is_empty()).then(|| Contacts {
        flags: rows.flat_map(|row| touching.iter().map(|body| row[*body] > 0.5)).collect(),
        names: touching.iter().map(|body| names[*body].clone()).collect(),
    })
}

fn write(clip: &MotionClip, context: &Context<'_>) -> Result<Vec<u8>, MotionError> {
    let Some(robot) = context.robot else { return Err(unfit(clip, "expected a robot (--robot), got none".to_owned())) };
    let bodies = Traversal::DepthFirst.bodies(robot);
    let states = kinematics::states(clip, robot, &bodies)?;
    let (frames, joints) = (clip.len(), clip.joint_names.len());
    let turns: Vec<f64> = states.orientation.iter().flat_map(|turn| Order::Xyzw.numbers(turn)).collect();
    let vectors = |name, vectors: &[lifelike_character::Vec3]| {
        let numbers: Vec<f64> = vectors.iter().flat_map(|vector| vector.iter().copied()).collect();
        (name, Entry::Array(Written::f32(name, &[frames, bodies.len(), 3], &numbers)))
    };
    let flags = bodies_in_contact(clip, bodies.iter().map(|body| robot.bodies[*body].name.as_str()).collect());
    encode::torch(&[
        ("dof_pos", Entry::Array(Written::f32("dof_pos", &[frames, joints], &states.joints))),
        ("dof_vel", Entry::Array(Written::f32("dof_vel", &[frames, joints], &states.joint_velocity))),
        vectors("rigid_body_pos", &states.position),
        ("rigid_body_rot", Entry::Array(Written::f32("rigid_body_rot", &[frames, bodies.len(), 4], &turns))),
        vectors("rigid_body_vel", &states.linear),
        vectors("rigid_body_ang_vel", &states.angular),
        (CONTACTS, Entry::Array(Written::flags(CONTACTS, &[frames, bodies.len()], flags))),
        ("fps", Entry::Float(clip.fps)),
    ])
    .map_err(|error| unfit(clip, error.to_string()))
}

/// Returns a flag for each frame and body; none is set where contacts are not known.
fn bodies_in_contact(clip: &MotionClip, bodies: Vec<&str>) -> Vec<u8> {
    let mut flags = vec![0; clip.len() * bodies.len()];
    let Some(contacts) = &clip.contacts else { return flags };
    for (place, name) in contacts.names.iter().enumerate() {
        let Some(body) = bodies.iter().position(|body| body == name) else { continue };
        for frame in 0..clip.len() {
            flags[frame * bodies.len() + body] = u8::from(contacts.flags[frame * contacts.names.len() + place]);
        }
    }
    flags
}
