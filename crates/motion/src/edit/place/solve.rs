//! The body that follows: the retargeter's inverse kinematics on the frames that keys reach.

use lifelike_character::{Kinematics, Vec3};

use super::offset::Track;
use super::pace;
use super::report::stands;
use crate::clip::MotionClip;
use crate::retarget::rig::{Rig, Spot};
use crate::retarget::solver::{Limits, Solver, Task};

/// Weights of residuals, which are lengths over the leg length, or radians.
mod weight {
    /// Ten times as firm as the key: what cannot be reached is not reached by sliding.
    pub const SOLE: f64 = 200.0;
    pub const SOLE_TURN: f64 = 120.0;
    pub const KEY: f64 = 20.0;
    pub const HIPS: f64 = 1.0;
    pub const PELVIS: f64 = 1.5;
    /// Joints between the root and the point move most easily.
    pub const NEAR: f64 = 0.05;
    pub const FAR: f64 = 0.25;
}

/// More than enough from the frame before; the solver stops when it stands still.
const ITERATIONS: usize = 100;
/// Largest slip of a sole while it stands (m).
const SLIP: f64 = 0.8e-3;
/// Largest deviation of a sole while it swings (m).
const SWING: f64 = 0.02;
/// Steps in which the share of the offsets is sought: to one part in 64.
const HALVINGS: usize = 6;

/// Returns the generalised positions in which the tracks' points are where they are to be, as nearly as the body can.
///
/// Every frame is solved for itself; then a joint whose way to a key would be too fast sets out earlier. At the end of
/// its reach a body jumps between contorted poses, and its feet give way: then all offsets are scaled down until the
/// soles keep their places.
pub(super) fn solve(rig: &Rig, clip: &MotionClip, old: &[Vec<f64>], tracks: &[Track]) -> Vec<Vec<f64>> {
    let fps = clip.fps;
    let home: Vec<bool> =
        (0..old.len()).map(|t| tracks.iter().all(|track| track.at(t as f64 / fps).is_none())).collect();
    let keys: Vec<usize> = tracks.iter().flat_map(|track| track.hits.iter().map(|hit| hit.frame)).collect();
    let try_share = |share: f64| {
        let mut new = follow(rig, old, tracks, fps, share);
        for axis in &rig.axes {
            // A clip that is faster itself stays as fast.
            let own = old.windows(2).map(|w| (w[1][axis.q] - w[0][axis.q]).abs());
            let mut values: Vec<f64> = new.iter().map(|q| q[axis.q]).collect();
            pace::pace(&mut values, own.fold(axis.speed / fps, f64::max), &home, &keys);
            for (q, value) in new.iter_mut().zip(values) {
                q[axis.q] = value;
            }
        }
        soles_keep(rig, clip, (old, &new), tracks).then_some(new)
    };
    let mut best = try_share(1.0);
    if best.is_none() {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let share = 0.5 * (low + high);
            match try_share(share) {
                Some(better) => (low, best) = (share, Some(better)),
                None => high = share,
            }
        }
    }
    best.unwrap_or_else(|| old.to_vec())
}

/// Returns whether the soles without keys stay in place.
fn soles_keep(rig: &Rig, clip: &MotionClip, (old, new): (&[Vec<f64>], &[Vec<f64>]), tracks: &[Track]) -> bool {
    let (mut before, mut after) = (Kinematics::new(rig.character), Kinematics::new(rig.character));
    (0..old.len()).filter(|&t| old[t] != new[t]).all(|t| {
        before.update(rig.character, &old[t]);
        after.update(rig.character, &new[t]);
        rig.legs.iter().filter(|leg| !is_keyed(tracks, leg.foot.body)).all(|leg| {
            let body = leg.foot.body;
            let most = if stands(clip, &rig.character.bodies[body].name, t) { SLIP } else { SWING };
            leg.foot.corners.iter().all(|c| (after.point(body, c) - before.point(body, c)).norm() < most)
        })
    })
}

fn is_keyed(tracks: &[Track], body: usize) -> bool {
    tracks.iter().any(|track| track.spot.body == body)
}

/// Follows the tracks frame by frame, with this share of the offsets, as fast as it takes.
fn follow(rig: &Rig, old: &[Vec<f64>], tracks: &[Track], fps: f64, share: f64) -> Vec<Vec<f64>> {
    let mut solver = Solver::new(rig, |_| true);
    let mut limits = Limits::new(rig);
    let near = near_joints(rig, tracks);
    let mut kinematics = Kinematics::new(rig.character);
    let mut new = old.to_vec();
    let mut tasks = Vec::new();
    for (t, pose) in old.iter().enumerate() {
        tasks.clear();
        kinematics.update(rig.character, pose);
        for track in tracks {
            if let Some(offset) = track.at(t as f64 / fps) {
                let target = kinematics.point(track.spot.body, &track.spot.point) + offset * share;
                tasks.push(Task::Position { spot: track.spot, target, weight: Vec3::repeat(weight::KEY) });
            }
        }
        if tasks.is_empty() {
            continue;
        }
        keep(rig, &kinematics, tracks, &mut tasks);
        // From this frame of the clip, moved as the frame before was moved: changes come and go smoothly.
        solver.q.copy_from_slice(pose);
        let before = t.checked_sub(1).map(|b| (&old[b], &new[b]));
        for (i, axis) in rig.axes.iter().enumerate() {
            let q = pose[axis.q];
            // A clip of others may be beyond the bounds that retargeting keeps; it is not to be pushed back by an edit.
            let (low, high) = (axis.low.min(q).max(axis.range.0), axis.high.max(q).min(axis.range.1));
            (limits.low[i], limits.high[i]) = (low, high);
            limits.wish[i] = q;
            limits.weight[i] = if near[i] { weight::NEAR } else { weight::FAR };
            let carried = before.map_or(q, |(old, new)| q + new[axis.q] - old[axis.q]);
            solver.q[axis.q] = carried.max(low).min(high);
        }
        if let Some((old, new)) = before {
            for i in rig.root.q_index..rig.root.q_index + 3 {
                solver.q[i] += new[i] - old[i];
            }
        }
        solver.solve(&tasks, &limits, ITERATIONS);
        new[t].copy_from_slice(&solver.q);
    }
    new
}

/// Keeps both feet, unless keys move them, and the trunk where it is.
fn keep(rig: &Rig, kinematics: &Kinematics, tracks: &[Track], tasks: &mut Vec<Task>) {
    for leg in &rig.legs {
        let body = leg.foot.body;
        if is_keyed(tracks, body) {
            continue;
        }
        let spot = Spot { body, point: leg.foot.under };
        let target = kinematics.point(body, &spot.point);
        tasks.push(Task::Position { spot, target, weight: Vec3::repeat(weight::SOLE) });
        let target = kinematics.body_orientation[body];
        tasks.push(Task::Orientation { body, target, weight: weight::SOLE_TURN });
    }
    let hips = kinematics.point(rig.hips.body, &rig.hips.point);
    tasks.push(Task::Position { spot: rig.hips, target: hips, weight: Vec3::repeat(weight::HIPS) });
    let (body, target) = (rig.pelvis.0, kinematics.body_orientation[rig.pelvis.0]);
    tasks.push(Task::Orientation { body, target, weight: weight::PELVIS });
}

/// Returns the joints between the root and a keyed point.
fn near_joints(rig: &Rig, tracks: &[Track]) -> Vec<bool> {
    let character = rig.character;
    let mut on_way = vec![false; character.bodies.len()];
    for track in tracks {
        let mut body = track.spot.body;
        while body != 0 {
            on_way[body] = true;
            body = character.bodies[body].parent;
        }
    }
    character.scalar_joints().map(|joint| on_way[joint.body]).collect()
}
