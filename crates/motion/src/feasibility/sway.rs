//! Shifts of a body above its feet.
//!
//! A shift s(t) of the whole body moves the zero moment point by s − (h / f) s̈. Here h is the height of the centre of
//! mass and f the vertical force per mass. For the point to move by e, that is a boundary value problem (a tridiagonal
//! system). Its solution spreads e over √(h / f), a fifth of a second here: what a body does before it brakes.

use lifelike_character::Vec3;

use super::Momentum;

/// In the air a shift is to go on as it is: a stiffness (frames²) above all others.
const AIRBORNE: f64 = 1e4;

/// Returns the shift of each frame (m) that moves its zero moment point by `missing` (m): s − k s̈ = e; at the ends s̈ is 0, in the air
/// too. `gravity` in m/s².
pub(crate) fn shift_for(momentum: &[Option<Momentum>], missing: &[Vec3], gravity: f64, fps: f64) -> Vec<Vec3> {
    let n = missing.len();
    let stiffness = |t: usize| {
        let own = momentum[t].as_ref().filter(|m| m.zero_moment_point.is_some());
        own.map_or(AIRBORNE, |m| m.centre.z / m.specific_force.z.max(0.3 * gravity) * fps * fps)
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
