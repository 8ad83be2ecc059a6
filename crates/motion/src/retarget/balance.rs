//! Balance over one foot: a body that stands on it for long is brought above it.
//!
//! A human's hips go sideways over the foot. A robot of other masses, or without ankles that roll, would fall over beside it. Walking
//! needs nothing of the kind: its steps are shorter than [`LONG`].

use lifelike_character::{Anatomy, Kinematics, Vec3};

use super::feet::Stance;
use super::passes;
use super::rig::{Rig, Spot};
use super::smooth;
use super::solver::{Limits, Solver, Task};
use crate::contacts::runs;
use crate::feasibility::{Momentum, centre_of_mass, momentum, nearest, shift_for, touches};

/// One foot alone carries the body for at least this long (s).
const LONG: f64 = 0.8;
/// Share of the sole, about its middle, in which the ground's force is to act.
const SHARE: f64 = 0.8;
/// Each round is right for the momentum of the one before.
const ROUNDS: usize = 2;
/// The largest shift, as a share of the legs.
const FARTHEST: f64 = 0.4;

/// Weights of the tasks, as those of [`passes`].
mod weight {
    pub const CENTRE: f64 = 30.0;
    pub const SOLE: f64 = 25.0;
    pub const FOOT: f64 = 60.0;
    /// A foot in the air keeps its place less than one that stands.
    pub const LIFTED: f64 = 3.0;
    pub const HIPS: f64 = 0.5;
    pub const PELVIS: f64 = 0.6;
}

/// Leans the body with root and legs over a foot that carries it for long. All other clips stay as they are, and so do those of a
/// character without mass.
pub(super) fn balance(
    rig: &Rig,
    anatomy: &Anatomy,
    poses: Vec<Vec<f64>>,
    stances: &[Stance; 2],
    sigma: f64,
    fps: f64,
) -> Vec<Vec<f64>> {
    let feet = feet_alone(stances, poses.len(), fps);
    if feet.iter().all(Option::is_none) {
        return poses;
    }
    let mut shift = vec![Vec3::zeros(); poses.len()];
    let mut now = poses.clone();
    for _ in 0..ROUNDS {
        let figures: Vec<Kinematics> = now.iter().map(|pose| figure(rig, pose)).collect();
        let momentum = momentum(rig.character, &figures, fps);
        let missing: Vec<Vec3> =
            (0..now.len()).map(|t| missing(rig, anatomy, &figures[t], momentum[t].as_ref(), feet[t])).collect();
        if missing.iter().all(|missing| *missing == Vec3::zeros()) {
            break;
        }
        for (own, more) in shift.iter_mut().zip(shift_for(&momentum, &missing, rig.character.gravity.norm(), fps)) {
            *own += more;
            *own /= (own.norm() / (FARTHEST * rig.leg_length)).max(1.0);
        }
        now = lean(rig, &poses, &shift, stances, fps);
        smooth::smooth_change(rig, &poses, &mut now, sigma);
    }
    now
}

fn figure(rig: &Rig, pose: &[f64]) -> Kinematics {
    let mut figure = Kinematics::new(rig.character);
    figure.update(rig.character, pose);
    figure
}

/// Returns for each frame the foot that stands alone for long.
fn feet_alone(stances: &[Stance; 2], frames: usize, fps: f64) -> Vec<Option<usize>> {
    let mut out = vec![None; frames];
    for side in 0..2 {
        let alone: Vec<bool> = (0..frames).map(|t| stances[side].any(t) && !stances[1 - side].any(t)).collect();
        for (start, end) in runs(&alone, true) {
            if (end - start) as f64 >= LONG * fps {
                out[start..end].fill(Some(side));
            }
        }
    }
    out
}

/// Returns by how much the point of the ground's force is to move for the foot that stands alone (m). It is zero where a knee, a hand or
/// another part stands, too.
fn missing(
    rig: &Rig,
    anatomy: &Anatomy,
    figure: &Kinematics,
    momentum: Option<&Momentum>,
    foot: Option<usize>,
) -> Vec3 {
    let (Some(foot), Some(point)) = (foot.map(|side| &rig.legs[side].foot), momentum.and_then(|m| m.zero_moment_point))
    else {
        return Vec3::zeros();
    };
    if touches(rig.character, anatomy, figure).other.is_some() {
        return Vec3::zeros();
    }
    let corners: Vec<Vec3> = foot.corners.iter().map(|corner| figure.point(foot.body, corner)).collect();
    let middle = corners.iter().sum::<Vec3>() / corners.len().max(1) as f64;
    let inner: Vec<Vec3> = corners.iter().map(|corner| middle + (corner - middle) * SHARE).collect();
    nearest(&inner, &point).map_or(Vec3::zeros(), |nearest| Vec3::new(nearest.x - point.x, nearest.y - point.y, 0.0))
}

/// Returns the poses with the centre of mass shifted over the ground, soles where they are.
fn lean(rig: &Rig, base: &[Vec<f64>], shift: &[Vec3], stances: &[Stance; 2], fps: f64) -> Vec<Vec<f64>> {
    let mut solver = Solver::new(rig, |i| rig.axes[i].leg);
    let mut limits = Limits::new(rig);
    let mut tasks = Vec::new();
    let mut poses: Vec<Vec<f64>> = Vec::with_capacity(base.len());
    for (t, pose) in base.iter().enumerate() {
        let figure = figure(rig, pose);
        tasks.clear();
        let target = centre_of_mass(rig.character, &figure) + shift[t];
        tasks.push(Task::Centre { target, weight: weight::CENTRE });
        let hips = figure.point(rig.hips.body, &rig.hips.point);
        tasks.push(Task::Position { spot: rig.hips, target: hips, weight: Vec3::repeat(weight::HIPS) });
        let (body, target) = (rig.pelvis.0, figure.body_orientation[rig.pelvis.0]);
        tasks.push(Task::Orientation { body, target, weight: weight::PELVIS });
        for (leg, stance) in rig.legs.iter().zip(stances) {
            let (body, point) = (leg.foot.body, leg.foot.under);
            let grip = if stance.any(t) { weight::SOLE } else { weight::LIFTED };
            let spot = Spot { body, point };
            let target = figure.point(body, &point);
            tasks.push(Task::Position { spot, target, weight: Vec3::repeat(grip) });
            let (target, weight) =
                (figure.body_orientation[body], if stance.any(t) { weight::FOOT } else { weight::LIFTED });
            tasks.push(Task::Orientation { body, target, weight });
        }
        let before = t.checked_sub(1).map(|b| (&base[b], &poses[b]));
        passes::carry(rig, pose, before, fps, &mut solver, &mut limits);
        solver.solve(&tasks, &limits, if t == 0 { 15 } else { 4 });
        poses.push(solver.q.clone());
    }
    poses
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_character::Character;

    use super::*;
    use crate::retarget::RetargetOptions;

    #[test]
    fn nothing_is_missing_where_another_part_of_the_body_lies_on_the_ground() {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/lima.xml");
        let character = Character::load(&file).unwrap();
        let anatomy = Anatomy::guess(&character, &Default::default()).unwrap();
        let rig = Rig::new(&character, &anatomy, &RetargetOptions::default()).unwrap();
        let far = Vec3::new(0.0, 1.0, 0.0);
        let momentum = Momentum { centre: far, specific_force: -character.gravity, zero_moment_point: Some(far) };
        let mut pose = character.reference_position();
        let standing = missing(&rig, &anatomy, &figure(&rig, &pose), Some(&momentum), Some(0));
        assert!(standing.y < -0.5, "{standing}");
        let at = rig.root.q_index;
        let half = std::f64::consts::FRAC_1_SQRT_2;
        pose[at + 2] = 0.05;
        pose[at + 3..at + 7].copy_from_slice(&[half, 0.0, half, 0.0]);
        let lying = missing(&rig, &anatomy, &figure(&rig, &pose), Some(&momentum), Some(0));
        assert_eq!(lying, Vec3::zeros());
    }
}
