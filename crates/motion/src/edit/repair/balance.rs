//! Sway: the body shifted above its feet so that the ground's force acts within them.
//!
//! A shift s(t) of the whole body moves the zero moment point by s − (h / f) s̈. Here h is the height of the centre of
//! mass and f the vertical force per mass. For the point to move by e, that is a boundary value problem (a tridiagonal
//! system). Its solution spreads e over √(h / f), a fifth of a second here: what a body does before it brakes.

use lifelike_character::Vec3;

use super::Needs;
use crate::feasibility::nearest;

/// The point is left this far outside (m): less than what counts ([`Kind::Unbalanced`](crate::feasibility::Kind)).
const OUTSIDE: f64 = 0.03;
/// Shorter stretches are left alone (s): less than half of what rules out.
const SHORT: f64 = 0.16;
/// The largest shift, as a share of the legs.
const FARTHEST: f64 = 0.4;

/// By how much each frame is shifted over the ground (m).
pub(super) struct Shift(Vec<Vec3>);

impl Shift {
    pub fn none(frames: usize) -> Self {
        Self(vec![Vec3::zeros(); frames])
    }

    /// Adds what is missing; whether anything is.
    pub fn improve(&mut self, needs: &Needs, leg_length: f64, fps: f64) -> bool {
        let missing = missing(needs, fps);
        if missing.iter().all(|e| *e == Vec3::zeros()) {
            return false;
        }
        for (own, more) in self.0.iter_mut().zip(solve(needs, &missing, fps)) {
            *own += more;
            let far = own.norm() / (FARTHEST * leg_length);
            if far > 1.0 {
                *own /= far;
            }
        }
        true
    }

    /// Returns generalised positions, shifted.
    pub fn applied(&self, positions: &[Vec<f64>], root: usize) -> Vec<Vec<f64>> {
        let mut out = positions.to_vec();
        for (q, shift) in out.iter_mut().zip(&self.0) {
            (q[root], q[root + 1]) = (q[root] + shift.x, q[root + 1] + shift.y);
        }
        out
    }
}

/// Returns by how much each frame's zero moment point is to move (m).
fn missing(needs: &Needs, fps: f64) -> Vec<Vec3> {
    let mut out: Vec<Vec3> = needs
        .momentum
        .iter()
        .zip(&needs.touches)
        .map(|(momentum, touch)| {
            let point = momentum.as_ref().and_then(|m| m.zero_moment_point);
            let Some((point, nearest)) = point.and_then(|p| Some((p, nearest(&touch.points, &p)?))) else {
                return Vec3::zeros();
            };
            let away = nearest - point;
            let far = away.xy().norm();
            if far > OUTSIDE { Vec3::new(away.x, away.y, 0.0) * (1.0 - 0.5 * OUTSIDE / far) } else { Vec3::zeros() }
        })
        .collect();
    let flags: Vec<bool> = out.iter().map(|e| *e != Vec3::zeros()).collect();
    for (start, end) in crate::contacts::runs(&flags, true) {
        if ((end - start) as f64) < SHORT * fps {
            out[start..end].fill(Vec3::zeros());
        }
    }
    out
}

/// Solves s − k s̈ = e; at the ends s̈ is 0, in the air too.
fn solve(needs: &Needs, missing: &[Vec3], fps: f64) -> Vec<Vec3> {
    let n = missing.len();
    let stiffness = |t: usize| {
        let own = needs.momentum[t].as_ref().filter(|m| m.zero_moment_point.is_some());
        own.map_or(AIRBORNE, |m| m.centre.z / m.specific_force.z.max(0.3 * needs.gravity) * fps * fps)
    };
    // Thomas' algorithm.
    let (mut upper, mut right) = (vec![0.0; n], vec![Vec3::zeros(); n]);
    for t in 0..n {
        let k = stiffness(t);
        let (below, above) = (if t > 0 { k } else { 0.0 }, if t + 1 < n { k } else { 0.0 });
        let (before, known) = if t > 0 { (upper[t - 1], right[t - 1]) } else { (0.0, Vec3::zeros()) };
        let pivot = 1.0 + below + above - below * before;
        upper[t] = above / pivot;
        right[t] = (missing[t] + known * below) / pivot;
    }
    for t in (0..n.saturating_sub(1)).rev() {
        let next = right[t + 1];
        right[t] += next * upper[t];
    }
    right
}

/// In the air a shift is to go on as it is: a stiffness (frames²) above all others.
const AIRBORNE: f64 = 1e4;
