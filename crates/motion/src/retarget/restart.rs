//! Getting a limb out of a wrong branch: Gauss-Newton stays in the valley it started in, and an arm that is twisted
//! against its joint limits stays there for the whole clip.

use super::rig::{Rig, Segment};
use super::solver::{Limits, Solver, Task};

/// Number of other starts that are tried.
const STARTS: usize = 8;
/// A limb whose segments' directions are off by more than this (sum of chords) is taken to be stuck. On the first frame
/// a jump costs nothing, so less will do.
const STUCK: f64 = 0.6;
const STUCK_AT_FIRST: f64 = 0.15;
/// The cost must fall to this share for a jump to be worth it.
const WORTH: f64 = 0.6;

/// The joints of one limb and its segments.
pub(super) struct Limb {
    axes: Vec<usize>,
    segments: Vec<Segment>,
    /// Frames until it may be tried again, and how long the last pause was.
    rest: usize,
    pause: usize,
}

/// Arms and legs of a rig.
pub(super) fn limbs(rig: &Rig) -> Vec<Limb> {
    let arms = rig.arms.iter().flatten().map(|a| vec![a.upper, a.fore]);
    let legs = rig.legs.iter().map(|l| vec![l.thigh, l.shank]);
    arms.chain(legs)
        .map(|segments| {
            // The joints between the segments' ends and the trunk: those that the trunk's body does not carry.
            let mut axes = Vec::new();
            let mut body = segments[1].to.body;
            let trunk = [rig.pelvis.0, rig.chest.map_or(0, |c| c.0), 0];
            while !trunk.contains(&body) {
                let joints = rig.character.bodies[body].joints.clone();
                axes.extend(
                    joints.filter_map(|j| rig.axes.iter().position(|a| a.v == rig.character.joints[j].v_index)),
                );
                body = rig.character.bodies[body].parent;
            }
            Limb { axes, segments, rest: 0, pause: 0 }
        })
        .collect()
}

/// Tries other starts for limbs that are stuck; keeps what is clearly better.
pub(super) fn free_stuck_limbs(rig: &Rig, solver: &mut Solver, tasks: &[Task], limits: &Limits, limbs: &mut [Limb]) {
    for limb in limbs.iter_mut() {
        limb.rest = limb.rest.saturating_sub(1);
        let allowed = if limb.pause == 0 { STUCK_AT_FIRST } else { STUCK };
        if limb.rest > 0 || limb.error(solver, tasks) < allowed {
            limb.pause = limb.pause.max(5);
            continue;
        }
        // What is out of reach stays so for a while: ask less and less often.
        limb.pause = (2 * limb.pause).clamp(5, 40);
        limb.rest = limb.pause;
        let mut wide = limits.clone();
        for &i in &limb.axes {
            (wide.low[i], wide.high[i]) = (rig.axes[i].low, rig.axes[i].high);
        }
        let start = solver.q.clone();
        let mut best = (solver.solve(tasks, limits, 2) * WORTH, solver.q.clone());
        for k in 1..=STARTS {
            solver.q.copy_from_slice(&start);
            for (n, &i) in limb.axes.iter().enumerate() {
                let (low, high) = (rig.axes[i].low.max(-3.0), rig.axes[i].high.min(3.0));
                solver.q[rig.axes[i].q] = low + (high - low) * halton(k, n);
            }
            let cost = solver.solve(tasks, &wide, 12);
            if cost < best.0 {
                limb.pause = 5;
                best = (cost, solver.q.clone());
            }
        }
        solver.q.copy_from_slice(&best.1);
        solver.kinematics.update(rig.character, &solver.q);
    }
}

impl Limb {
    /// Returns by how much the limb's segments point elsewhere than asked (sum of the chords).
    fn error(&self, solver: &Solver, tasks: &[Task]) -> f64 {
        let off = |task: &Task| match task {
            Task::Direction { segment, target, .. } => {
                let mine = self.segments.iter().any(|s| s.to.body == segment.to.body && s.to.point == segment.to.point);
                let at = |spot: &super::rig::Spot| solver.kinematics.point(spot.body, &spot.point);
                mine.then(|| ((at(&segment.to) - at(&segment.from)) / segment.length - target).norm())
            }
            _ => None,
        };
        tasks.iter().filter_map(off).sum()
    }
}

/// Returns the `k`-th point of the low-discrepancy sequence in dimension `n`.
fn halton(k: usize, n: usize) -> f64 {
    let base = [2, 3, 5, 7, 11, 13, 17, 19][n % 8];
    let (mut k, mut share, mut value) = (k, 1.0, 0.0);
    while k > 0 {
        share /= base as f64;
        value += share * (k % base) as f64;
        k /= base;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::halton;

    #[test]
    fn halton_by_hand() {
        assert_eq!([1, 2, 3, 4].map(|k| halton(k, 0)), [0.5, 0.25, 0.75, 0.125]);
        assert!((halton(4, 1) - 4.0 / 9.0).abs() < 1e-15);
    }
}
