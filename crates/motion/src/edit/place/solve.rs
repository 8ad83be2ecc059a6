//! The body that follows: the retargeter's inverse kinematics on the frames that keys reach.

use lifelike_character::{Kinematics, Vec3};

use super::offset::Track;
use crate::retarget::rig::{Rig, Spot};
use crate::retarget::smooth::limit_speed;
use crate::retarget::solver::{Limits, Solver, Task};

/// Weights of residuals, which are lengths over the leg length, or radians.
mod weight {
    /// Firmer than the key: what cannot be reached is not reached by walking.
    pub const SOLE: f64 = 100.0;
    pub const SOLE_TURN: f64 = 60.0;
    pub const KEY: f64 = 40.0;
    pub const HIPS: f64 = 2.0;
    pub const PELVIS: f64 = 3.0;
    /// Joints between the root and the point move most easily.
    pub const NEAR: f64 = 0.1;
    pub const FAR: f64 = 0.5;
}

/// More than enough from the frame before; the solver stops when it stands still.
const ITERATIONS: usize = 40;

/// Generalised positions in which the tracks' points are where they are to be, as nearly as the body can.
pub(super) fn solve(rig: &Rig, old: &[Vec<f64>], tracks: &[Track], fps: f64) -> Vec<Vec<f64>> {
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
                let target = kinematics.point(track.spot.body, &track.spot.point) + offset;
                tasks.push(Task::Position { spot: track.spot, target, weight: Vec3::repeat(weight::KEY) });
            }
        }
        if tasks.is_empty() {
            continue;
        }
        keep(rig, &kinematics, tracks, &mut tasks);
        // From this frame of the clip, moved as the frame before was moved: changes come and go smoothly.
        solver.q.copy_from_slice(pose);
        for (i, axis) in rig.axes.iter().enumerate() {
            // A clip of others may be beyond the bounds that retargeting keeps; it is not to be pushed back by an edit.
            let q = pose[axis.q];
            (limits.low[i], limits.high[i]) = (axis.low.min(q).max(axis.range.0), axis.high.max(q).min(axis.range.1));
            limits.wish[i] = q;
            limits.weight[i] = if near[i] { weight::NEAR } else { weight::FAR };
            let carried = t.checked_sub(1).map_or(q, |b| q + new[b][axis.q] - old[b][axis.q]);
            solver.q[axis.q] = carried.max(limits.low[i]).min(limits.high[i]);
        }
        let at = rig.root.q_index;
        if let Some(b) = t.checked_sub(1) {
            for i in at..at + 3 {
                solver.q[i] += new[b][i] - old[b][i];
            }
        }
        solver.solve(&tasks, &limits, ITERATIONS);
        new[t].copy_from_slice(&solver.q);
    }
    no_faster(rig, old, &mut new, fps);
    new
}

/// Both feet, unless keys move them, and the trunk where it is.
fn keep(rig: &Rig, kinematics: &Kinematics, tracks: &[Track], tasks: &mut Vec<Task>) {
    for leg in &rig.legs {
        let body = leg.foot.body;
        if tracks.iter().any(|track| track.spot.body == body) {
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

/// Which joints are between the root and a keyed point.
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

/// No joint faster than its limit, or than the clip itself was.
fn no_faster(rig: &Rig, old: &[Vec<f64>], new: &mut [Vec<f64>], fps: f64) {
    for axis in &rig.axes {
        let steps = old.windows(2).map(|w| (w[1][axis.q] - w[0][axis.q]).abs());
        let largest = steps.fold(axis.speed / fps, f64::max);
        let mut column: Vec<f64> = new.iter().map(|q| q[axis.q]).collect();
        limit_speed(&mut column, largest);
        for (q, value) in new.iter_mut().zip(column) {
            q[axis.q] = value;
        }
    }
}
