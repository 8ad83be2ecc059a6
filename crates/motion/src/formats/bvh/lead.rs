//! A rest pose before the motion, as `MotionBuilder`, `SlimeVR` and others write it.

use lifelike_character::{Quat, Vec3};

/// Longest rest pose that is looked for (s).
const LONGEST: f64 = 1.0;
/// Largest change of a joint while a pose is held (rad).
const HELD: f64 = 0.01;
/// Smallest jump from a rest pose into the motion (rad).
const JUMP: f64 = 0.3;
/// The jump against the largest change of the frames after it: from a pose of zero rotations, and from any other.
const FACTORS: [f64; 2] = [1.5, 4.0];

/// Removes the frames of a rest pose at the start: a pose that is held, and left by a jump which no later frame makes.
pub(super) fn drop_rest_pose(
    places: &mut Vec<Vec3>,
    rotations: &mut Vec<Vec<Quat>>,
    fps: f64,
    notes: &mut Vec<String>,
) {
    let change = |t: usize| rotations[t].iter().zip(&rotations[t + 1]).map(|(a, b)| a.angle_to(b)).fold(0.0, f64::max);
    let last = rotations.len() - 1;
    let longest = ((LONGEST * fps) as usize).max(1).min(last);
    let Some(at) = (0..longest).find(|&t| change(t) > HELD) else { return };
    let after = (at + 1..last.min(at + 1 + longest.max(10))).map(change).fold(0.0, f64::max);
    let is_zero = rotations[at].iter().skip(1).all(|turn| turn.angle() < HELD);
    let factor = FACTORS[usize::from(!is_zero)];
    if last < at + 3 || change(at) < JUMP.max(factor * after) {
        return;
    }
    notes.push(format!(
        "frames 1 to {} are a rest pose that the motion leaves by a jump of {:.0} degrees: they were left out",
        at + 1,
        change(at).to_degrees()
    ));
    places.drain(..=at);
    rotations.drain(..=at);
}
