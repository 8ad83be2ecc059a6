//! Evidence for quaternions whose parts stand in another order.

use lifelike_character::{Quat, Vec3};
use nalgebra::Quaternion;

use crate::clip::MotionClip;

/// Speed (m/s) from which a root goes somewhere.
const GOES: f64 = 0.1;
/// Largest tilt (rad) of a root that stands.
const UPRIGHT: f64 = 0.5;

/// Returns the share of the way on which the root goes backwards as it is oriented, and forwards with each quaternion
/// read as `x y z w`; 0 where either reading is not upright throughout.
pub(super) fn backwards(clip: &MotionClip) -> f64 {
    let other: Option<Vec<Quat>> = clip.root_orientation.iter().map(reordered).collect();
    let Some(other) = other else { return 0.0 };
    let upright = |turns: &[Quat]| turns.iter().all(|turn| (turn * Vec3::z()).z > UPRIGHT.cos());
    if !upright(&clip.root_orientation) || !upright(&other) {
        return 0.0;
    }
    let (mut all, mut contrary) = (0.0, 0.0);
    for (frame, step) in clip.root_position.windows(2).map(|pair| (pair[1] - pair[0]).xy()).enumerate() {
        if step.norm() * clip.fps < GOES {
            continue;
        }
        let along = |turn: &Quat| (turn * Vec3::x()).xy().dot(&step) / step.norm();
        all += step.norm();
        if along(&clip.root_orientation[frame]) < -0.7 && along(&other[frame]) > 0.7 {
            contrary += step.norm();
        }
    }
    if all > 0.0 { contrary / all } else { 0.0 }
}

/// Returns the rotation whose parts `w x y z` were meant as `x y z w`.
fn reordered(turn: &Quat) -> Option<Quat> {
    let parts = Quaternion::new(turn.k, turn.w, turn.i, turn.j);
    (parts.norm() > 1e-9).then(|| Quat::new_normalize(parts))
}
