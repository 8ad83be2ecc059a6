//! Two clips into one motion: joints linearly, tilt by slerp, height linearly, and the way over the ground by its
//! VELOCITY.
//!
//! Places cannot be mixed: between one who walked off and one who stands there is nobody. Steps can: the result walks at
//! the mixed speed and turns at the mixed rate, so its velocities are those of its positions.

use super::joints::like;
use super::path::{Posture, Stand, continuous};
use super::story::{captions, provenance, unfit};
use crate::clip::{Contacts, MotionClip};
use crate::error::MotionError;

/// Writes a pose between frame `i` of `a` and frame `j` of `b`, at a place on the ground, written into frame `to` of
/// `out`. All three have the same joints in the same order.
pub(super) fn mix(
    out: &mut MotionClip,
    to: usize,
    (a, i): (&MotionClip, usize),
    (b, j): (&MotionClip, usize),
    weight: f64,
    stand: &Stand,
) {
    let posture = Posture::of(a, i).between(&Posture::of(b, j), weight);
    (out.root_position[to], out.root_orientation[to]) = posture.at(stand);
    let width = out.joint_names.len();
    let rows = a.joints_at(i).iter().zip(b.joints_at(j));
    for (value, (a, b)) in out.joints[to * width..(to + 1) * width].iter_mut().zip(rows) {
        // Exact at both ends, which `a + weight * (b - a)` is not.
        *value = (1.0 - weight) * a + weight * b;
    }
}

/// Returns the step over the ground into frame `i` of `a` and frame `j` of `b`, mixed.
pub(super) fn mixed_step((a, i): (&MotionClip, usize), (b, j): (&MotionClip, usize), weight: f64) -> Stand {
    let step = |clip: &MotionClip, t: usize| Stand::of(clip, t - 1).step_to(&Stand::of(clip, t));
    step(a, i).between(&step(b, j), weight)
}

/// Returns the names in both.
pub(super) fn common_contacts(a: &[bool], b: &[bool]) -> Vec<bool> {
    a.iter().zip(b).map(|(a, b)| *a && *b).collect()
}

/// Returns the contacts of both, where both know them of the same places.
pub(super) fn comparable<'a>(a: &'a MotionClip, b: &'a MotionClip) -> Option<(&'a Contacts, &'a Contacts)> {
    match (&a.contacts, &b.contacts) {
        (Some(a), Some(b)) if a.names == b.names => Some((a, b)),
        _ => None,
    }
}

/// Blends `weight` of the second clip in the first (0: the first alone, 1: the second alone, on the first one's place),
/// frame by frame from both starts, at the first one's rate, as long as the shorter. A foot stands where it stands in
/// both.
///
/// # Errors
/// [`MotionError::Unfit`] for a weight outside of 0 to 1, or clips of different joints.
pub fn blend(a: &MotionClip, b: &MotionClip, weight: f64) -> Result<MotionClip, MotionError> {
    if !(0.0..=1.0).contains(&weight) {
        return Err(unfit(b, format!("expected a weight from 0 to 1, got {weight}")));
    }
    let b = &like(a, b)?;
    let frames = a.len().min(b.len());
    let seconds = (frames - 1) as f64 / a.fps;
    let mut told = captions(a, seconds, |t| t);
    told.extend(captions(b, seconds, |t| t));
    let width = a.joint_names.len();
    let mut out = MotionClip {
        name: format!("{}~{}", a.name, b.name),
        fps: a.fps,
        joint_names: a.joint_names.clone(),
        root_position: a.root_position[..frames].to_vec(),
        root_orientation: a.root_orientation[..frames].to_vec(),
        joints: a.joints[..frames * width].to_vec(),
        contacts: comparable(a, b).map(|(a, b)| {
            let count = frames * a.names.len();
            Contacts { names: a.names.clone(), flags: common_contacts(&a.flags[..count], &b.flags[..count]) }
        }),
        cyclic: a.cyclic && b.cyclic && a.len() == b.len(),
        provenance: provenance(&[a, b], format!("'{}' with {weight} of '{}'", a.name, b.name), told),
    };
    let mut stand = Stand::of(a, 0);
    for t in 0..frames {
        if t > 0 {
            stand = stand.after(&mixed_step((a, t), (b, t), weight));
        }
        mix(&mut out, t, (a, t), (b, t), weight, &stand);
    }
    continuous(&mut out.root_orientation);
    Ok(out)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::fixtures::clip;
    use lifelike_character::{Quat, Vec3};

    /// Walks ahead at this speed (m/s) while turning at this rate (rad/s).
    fn walker(speed: f64, rate: f64, height: f64, joint: f64) -> MotionClip {
        let mut c = clip(51, |_| [joint, 0.0]);
        let mut at = Stand { place: Vec3::zeros(), heading: 0.0 };
        let step = Stand { place: Vec3::new(speed / c.fps, 0.0, 0.0), heading: rate / c.fps };
        for t in 0..c.len() {
            c.root_position[t] = at.place + Vec3::new(0.0, 0.0, height);
            c.root_orientation[t] = Quat::from_euler_angles(0.0, 0.1, at.heading);
            at = at.after(&step);
        }
        c
    }

    #[test]
    fn half_of_each_walks_at_the_mean_speed_and_turns_at_the_mean_rate() {
        let out = blend(&walker(1.0, 0.0, 0.5, 0.0), &walker(2.0, 1.0, 0.7, 1.0), 0.5).unwrap();
        let expected = walker(1.5, 0.5, 0.6, 0.5);
        for t in 0..out.len() {
            assert!((out.root_position[t] - expected.root_position[t]).norm() < 1e-9, "{t}");
            assert!(out.root_orientation[t].angle_to(&expected.root_orientation[t]) < 1e-7);
            assert_eq!(out.joints_at(t), expected.joints_at(t));
        }
    }

    #[test]
    fn nothing_of_the_other_is_the_one() {
        let (a, mut b) = (walker(1.0, 2.0, 0.5, 0.3), walker(0.0, 0.0, 0.7, 1.0));
        // Where the other one is does not matter.
        b.root_position.iter_mut().for_each(|p| p.x += 7.0);
        let out = blend(&a, &b, 0.0).unwrap();
        for t in 0..a.len() {
            assert!((out.root_position[t] - a.root_position[t]).norm() < 1e-9);
        }
        let all = blend(&a, &b, 1.0).unwrap();
        assert!(all.root_position.iter().all(|p| (p - Vec3::new(0.0, 0.0, 0.7)).norm() < 1e-12));
        assert!(blend(&a, &b, 1.1).is_err() && blend(&a, &b, f64::NAN).is_err());
    }
}
