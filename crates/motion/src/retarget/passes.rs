//! The two passes over a clip: follow the human; then stand where one stands.

use lifelike_character::rotation::to_wxyz;
use lifelike_character::{Quat, Vec3};

use super::feet::FootTarget;
use super::human::{Human, HumanFrame};
use super::restart;
use super::rig::{Rig, Spot};
use super::shapes::Shapes;
use super::smooth::orientation;
use super::solver::{Limits, Solver, Task};

/// Weights of the tasks: residuals are lengths over the leg length, or radians (see [`Task`]).
mod weight {
    pub const HIPS: f64 = 2.0;
    pub const PELVIS: f64 = 1.2;
    pub const CHEST: f64 = 0.8;
    pub const LIMB: f64 = 1.0;
    pub const LEG: f64 = 0.4;
    pub const SOLE: f64 = 1.5;
    pub const FOLLOW: super::Grip = super::Grip { place: 0.0, ends: SOLE, height: 8.0 };
    pub const FOOT_FORWARD: f64 = 0.4;
    pub const FOOT_LEVEL: f64 = 1.5;
    pub const HAND: f64 = 0.4;
    pub const PALM: f64 = 0.15;
    pub const GAZE: f64 = 0.6;
    pub const HEAD_ROLL: f64 = 0.2;
    pub const FLOOR: f64 = 4.0;
    pub const APART: f64 = 8.0;
    /// Towards the pose as written, for what no task asks.
    pub const NEUTRAL: f64 = 0.04;
    /// Towards the frame before.
    pub const STEADY: f64 = 0.08;
    pub const LOCK: super::Grip = super::Grip { place: 25.0, ends: 12.0, height: 20.0 };
    pub const KEEP_HIPS: f64 = 2.0;
    pub const KEEP_PELVIS: f64 = 3.0;
    pub const KEEP_JOINT: f64 = 0.25;
    /// Towards the change that the frame before needed.
    pub const CARRY: f64 = 0.8;
}

/// Pass A: whole-body inverse kinematics, frame after frame, each started from the one before. Returns generalised
/// positions.
pub(super) fn follow(
    rig: &Rig,
    shapes: &Shapes,
    human: &Human,
    soles: &[Vec<FootTarget>; 2],
    fps: f64,
) -> Vec<Vec<f64>> {
    let scale = rig.leg_length / human.leg_length;
    let mut solver = Solver::new(rig, |_| true);
    let mut limits = Limits::new(rig);
    let mut tasks = Vec::new();
    let at = rig.root.q_index;
    for axis in &rig.axes {
        solver.q[axis.q] = axis.neutral.clamp(axis.low, axis.high);
    }
    let mut limbs = restart::limbs(rig);
    let mut poses = Vec::with_capacity(human.frames.len());
    for (t, frame) in human.frames.iter().enumerate() {
        tasks.clear();
        whole_body_tasks(rig, frame, scale, &mut tasks);
        for (side, targets) in soles.iter().enumerate() {
            sole_tasks(rig, side, &targets[t], &weight::FOLLOW, &mut tasks);
        }
        let first = t == 0;
        if first {
            // Start where the pelvis is, looking where it looks.
            solver.q[at + 3..at + 7].copy_from_slice(&to_wxyz(&(frame.pelvis * rig.pelvis.1)));
            solver.q[at..at + 3].copy_from_slice((frame.hips * scale).as_slice());
        }
        for (i, axis) in rig.axes.iter().enumerate() {
            // A generous limit keeps one branch of the solution; the real one is applied without delay afterwards.
            let (before, reach) = (solver.q[axis.q], if first { 1e3 } else { 2.0 * axis.speed / fps });
            limits.low[i] = axis.low.max(before - reach).min(axis.high);
            limits.high[i] = axis.high.min(before + reach).max(axis.low);
            let (n, s) = (weight::NEUTRAL * weight::NEUTRAL, weight::STEADY * weight::STEADY);
            limits.wish[i] = (n * axis.neutral + s * before) / (n + s);
            limits.weight[i] = (n + s).sqrt();
        }
        solver.solve(&tasks, &limits, if first { 60 } else { 4 });
        restart::free_stuck_limbs(rig, &mut solver, &tasks, &limits, &mut limbs);
        // Points of contact move with the pose: look again after each push.
        let asked = tasks.len();
        for _ in 0..2 {
            tasks.truncate(asked);
            let standing = [soles[0][t].stands(), soles[1][t].stands()];
            if !push_apart(rig, shapes, &mut solver, standing, &mut tasks) {
                break;
            }
            solver.solve(&tasks, &limits, 2);
        }
        poses.push(solver.q.clone());
    }
    poses
}

/// Asks every part that reached below the ground to come up, and parts in each other to part. Returns whether there
/// were any.
fn push_apart(rig: &Rig, shapes: &Shapes, solver: &mut Solver, standing: [bool; 2], tasks: &mut Vec<Task>) -> bool {
    solver.kinematics.update(rig.character, &solver.q);
    let before = tasks.len();
    shapes.for_each_below(&solver.kinematics, 0.0, |body, point, _| {
        // A standing foot has its own tasks.
        if !(0..2).any(|side| standing[side] && rig.legs[side].foot.body == body) {
            let weight = Vec3::new(0.0, 0.0, weight::FLOOR);
            tasks.push(Task::Position { spot: Spot { body, point }, target: Vec3::zeros(), weight });
        }
    });
    let margin = 0.01 * rig.leg_length;
    shapes.for_each_touching(&solver.kinematics, margin, |a, b, normal, distance| {
        tasks.push(Task::Apart { a, b, normal, distance, weight: weight::APART });
    });
    tasks.len() > before
}

fn whole_body_tasks(rig: &Rig, frame: &HumanFrame, scale: f64, tasks: &mut Vec<Task>) {
    tasks.push(Task::Position { spot: rig.hips, target: frame.hips * scale, weight: Vec3::repeat(weight::HIPS) });
    let orientation =
        |part: (usize, Quat), turn: Quat, weight| Task::Orientation { body: part.0, target: turn * part.1, weight };
    tasks.push(orientation(rig.pelvis, frame.pelvis, weight::PELVIS));
    if let Some(chest) = rig.chest {
        tasks.push(orientation(chest, frame.chest, weight::CHEST));
    }
    if let (Some((body, rest)), Some(head)) = (rig.head, frame.head) {
        let mut axis = |v: Vec3, w: f64| {
            tasks.push(Task::Axis { body, axis: rest.inverse() * v, target: head * v, weight: Vec3::repeat(w) });
        };
        axis(Vec3::x(), weight::GAZE);
        axis(Vec3::z(), weight::HEAD_ROLL);
    }
    for (leg, pose) in rig.legs.iter().zip(&frame.legs) {
        tasks.push(Task::Direction { segment: leg.thigh, target: pose.thigh, weight: weight::LEG });
        tasks.push(Task::Direction { segment: leg.shank, target: pose.shank, weight: weight::LEG });
    }
    for (arm, pose) in rig.arms.iter().zip(&frame.arms) {
        let (Some(arm), Some(pose)) = (arm, pose) else { continue };
        tasks.push(Task::Direction { segment: arm.upper, target: pose.upper, weight: weight::LIMB });
        tasks.push(Task::Direction { segment: arm.fore, target: pose.fore, weight: weight::LIMB });
        if let Some((body, along, palm)) = arm.hand {
            // Without fingers in the capture, the hand continues the forearm.
            let (direction, normal) = pose.hand.map_or((pose.fore, None), |(d, n)| (d, Some(n)));
            tasks.push(Task::Axis { body, axis: along, target: direction, weight: Vec3::repeat(weight::HAND) });
            if let Some(normal) = normal {
                tasks.push(Task::Axis { body, axis: palm, target: normal, weight: Vec3::repeat(weight::PALM) });
            }
        }
    }
}

/// Weight with which a sole is held while it stands.
struct Grip {
    /// The place of what stands: both ends' middle, or the one end.
    place: f64,
    /// Each end's place on the ground, so the yaw: softer, for hips that cannot turn as far give way here.
    ends: f64,
    /// Each end's height.
    height: f64,
}

/// Adds tasks for both ends of a sole, its direction, and level sideways while it stands.
fn sole_tasks(rig: &Rig, side: usize, target: &FootTarget, grip: &Grip, tasks: &mut Vec<Task>) {
    let foot = &rig.legs[side].foot;
    let body = foot.body;
    for ((point, at), hold) in [foot.toe, foot.heel].into_iter().zip(target.ends).zip(target.hold) {
        let w = |held: f64| weight::SOLE + (held - weight::SOLE) * hold * hold;
        let weight = Vec3::new(w(grip.ends), w(grip.ends), w(grip.height));
        tasks.push(Task::Position { spot: Spot { body, point }, target: at, weight });
    }
    let [toe, heel] = target.hold;
    let hold = toe.max(heel);
    if hold > 0.0 {
        let share = toe / (toe + heel);
        let point = foot.heel.lerp(&foot.toe, share);
        let at = target.ends[1].lerp(&target.ends[0], share);
        let w = grip.place * hold * hold;
        tasks.push(Task::Position { spot: Spot { body, point }, target: at, weight: Vec3::new(w, w, 0.0) });
    }
    let back = foot.rest.inverse();
    let forward = target.orientation * Vec3::x();
    let weight = Vec3::repeat(weight::FOOT_FORWARD);
    tasks.push(Task::Axis { body, axis: back * Vec3::x(), target: forward, weight });
    let level = 0.3 + (weight::FOOT_LEVEL - 0.3) * hold;
    // The foot's left axis: level while it stands, and pointing to where it pointed when it came down.
    let turn = grip.ends * target.turn_hold * target.turn_hold;
    let weight = Vec3::new(turn, turn, level);
    tasks.push(Task::Axis { body, axis: back * Vec3::y(), target: target.left, weight });
}

/// Pass B: only the root and the legs move, to put the soles exactly where they are locked; otherwise everything stays
/// as it is in `base`.
pub(super) fn stand(
    rig: &Rig,
    base: &[Vec<f64>],
    soles: &[Vec<FootTarget>; 2],
    fps: f64,
    iterations: usize,
) -> Vec<Vec<f64>> {
    let mut solver = Solver::new(rig, |i| rig.axes[i].leg);
    let mut limits = Limits::new(rig);
    let mut tasks = Vec::new();
    let mut kinematics = lifelike_character::Kinematics::new(rig.character);
    let mut poses: Vec<Vec<f64>> = Vec::with_capacity(base.len());
    for (t, pose) in base.iter().enumerate() {
        kinematics.update(rig.character, pose);
        tasks.clear();
        let hips = kinematics.point(rig.hips.body, &rig.hips.point);
        tasks.push(Task::Position { spot: rig.hips, target: hips, weight: Vec3::repeat(weight::KEEP_HIPS) });
        let (body, target) = (rig.pelvis.0, kinematics.body_orientation[rig.pelvis.0]);
        tasks.push(Task::Orientation { body, target, weight: weight::KEEP_PELVIS });
        for (side, targets) in soles.iter().enumerate() {
            sole_tasks(rig, side, &targets[t], &weight::LOCK, &mut tasks);
        }
        let before = t.checked_sub(1).map(|b| (&base[b], &poses[b]));
        carry(rig, pose, before, fps, &mut solver, &mut limits);
        solver.solve(&tasks, &limits, if t == 0 { 15 } else { iterations });
        poses.push(solver.q.clone());
    }
    poses
}

/// Starts from a frame of the base, moved as the frame `before` was moved: that of the base, and what became of it.
pub(super) fn carry(
    rig: &Rig,
    pose: &[f64],
    before: Option<(&Vec<f64>, &Vec<f64>)>,
    fps: f64,
    solver: &mut Solver,
    limits: &mut Limits,
) {
    let at = rig.root.q_index;
    solver.q.copy_from_slice(pose);
    if let Some((old, new)) = before {
        for i in at..at + 3 {
            solver.q[i] += new[i] - old[i];
        }
        let turn = orientation(pose, at) * orientation(old, at).inverse() * orientation(new, at);
        solver.q[at + 3..at + 7].copy_from_slice(&to_wxyz(&turn));
    }
    for (i, axis) in rig.axes.iter().enumerate() {
        let (mut low, mut high) = (axis.low, axis.high);
        if let Some((old, new)) = before {
            let reach = axis.speed / fps;
            low = low.max(new[axis.q] - reach).min(high);
            high = high.min(new[axis.q] + reach).max(low);
            solver.q[axis.q] += new[axis.q] - old[axis.q];
        }
        (limits.low[i], limits.high[i]) = (low, high);
        // Where the base is, and how far from the base the frame before was.
        let carried = solver.q[axis.q];
        let (k, s) = (weight::KEEP_JOINT * weight::KEEP_JOINT, weight::CARRY * weight::CARRY);
        limits.wish[i] = (k * pose[axis.q] + s * carried) / (k + s);
        limits.weight[i] = (k + s).sqrt();
        solver.q[axis.q] = carried.clamp(low, high);
    }
}
