//! Sway: the body shifted above its feet so that the ground's force acts within them.

use lifelike_character::Vec3;

use super::Needs;
use crate::feasibility::{nearest, shift_for};

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
        for (own, more) in self.0.iter_mut().zip(shift_for(&needs.momentum, &missing, needs.gravity, fps)) {
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
