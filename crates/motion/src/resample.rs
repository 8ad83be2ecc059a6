//! Between the frames: motion at any rate and any time.
//!
//! Joints and positions are interpolated linearly, orientations by slerp along the shorter way, contacts by the nearest
//! frame. There is no low-pass filter: going down in rate keeps what is there at the new instants.

use lifelike_character::Quat;

use crate::clip::{Contacts, MotionClip};
use crate::error::MotionError;
use crate::features::Frame;

/// The highest rate that is believed (Hz).
const FPS_MAX: f64 = 10_000.0;
/// The longest result that is made (frames).
const FRAMES_MAX: f64 = 1e7;

/// Interpolates spherically along the shorter way; exact at `t = 0` and `t = 1`.
pub fn slerp(a: &Quat, b: &Quat, t: f64) -> Quat {
    if t <= 0.0 {
        return *a;
    }
    if t >= 1.0 {
        return *b;
    }
    a * Quat::from_scaled_axis((a.inverse() * b).scaled_axis() * t)
}

/// Returns a time as the frame before it and the share of the way to the next one. Times outside the clip are its ends.
///
/// `index` is in frames and may lie between two of them; `len` is at least 1.
pub fn locate(index: f64, len: usize) -> (usize, f64) {
    let last = len.saturating_sub(1);
    // NaN goes to the first frame: the comparison is false for it.
    let index = if index > 0.0 { index.min(last as f64) } else { 0.0 };
    let before = (index.floor() as usize).min(last);
    let share = index - before as f64;
    // Times that are multiples of a step meet the frames up to rounding: snap, so that nothing is blended for nothing.
    const ROUNDING: f64 = 1e-9;
    match share {
        s if s < ROUNDING => (before, 0.0),
        s if s > 1.0 - ROUNDING => ((before + 1).min(last), 0.0),
        s => (before, s),
    }
}

/// Returns the clip at another rate: frame `i` of the result is the clip at `i / fps` seconds. The rest after the last
/// full period (less than `1 / fps`) is dropped.
///
/// # Errors
/// [`MotionError::Unfit`] for a rate that is not positive and below 10 kHz, or an empty or inconsistent clip.
pub fn resample(clip: &MotionClip, fps: f64) -> Result<MotionClip, MotionError> {
    clip.check()?;
    if !(fps > 0.0 && fps <= FPS_MAX) {
        return Err(unfit(clip, format!("cannot be resampled to {fps} Hz: expected 0 < rate <= {FPS_MAX}")));
    }
    if fps == clip.fps {
        return Ok(clip.clone());
    }
    let frames = (clip.seconds() * fps + 1e-6).floor() + 1.0;
    if frames > FRAMES_MAX {
        return Err(unfit(clip, format!("{frames} frames at {fps} Hz are more than the {FRAMES_MAX} that we make")));
    }
    Ok(at_frames(clip, fps, (0..frames as usize).map(|i| i as f64 * clip.fps / fps)))
}

/// Returns the clip at these places (in its own frames, see [`locate`]), which become the frames of a clip of `fps`
/// frames per second. The clip must be consistent ([`MotionClip::check`]).
pub(crate) fn at_frames(clip: &MotionClip, fps: f64, places: impl ExactSizeIterator<Item = f64>) -> MotionClip {
    let (frames, width) = (places.len(), clip.joint_names.len());
    let mut out = MotionClip {
        name: clip.name.clone(),
        fps,
        joint_names: clip.joint_names.clone(),
        root_position: Vec::with_capacity(frames),
        root_orientation: Vec::with_capacity(frames),
        joints: Vec::with_capacity(frames * width),
        contacts: clip.contacts.as_ref().map(|c| Contacts { names: c.names.clone(), flags: Vec::new() }),
        cyclic: clip.cyclic,
        provenance: clip.provenance.clone(),
    };
    for place in places {
        let (before, share) = locate(place, clip.len());
        let after = (before + 1).min(clip.len() - 1);
        out.root_position.push(clip.root_position[before].lerp(&clip.root_position[after], share));
        let turn = slerp(&clip.root_orientation[before], &clip.root_orientation[after], share);
        out.root_orientation.push(turn);
        let rows = clip.joints_at(before).iter().zip(clip.joints_at(after));
        out.joints.extend(rows.map(|(a, b)| a + (b - a) * share));
        if let (Some(from), Some(to)) = (&clip.contacts, &mut out.contacts) {
            let nearest = if share < 0.5 { before } else { after };
            let places = from.names.len();
            to.flags.extend_from_slice(&from.flags[nearest * places..(nearest + 1) * places]);
        }
    }
    out
}

/// Writes the instant at `index` frames (may lie between two; outside, the ends) written into `out`, whose vectors are
/// reused.
///
/// An empty slice leaves `out` as it is.
pub fn frame_at(frames: &[Frame], index: f64, out: &mut Frame) {
    if frames.is_empty() {
        return;
    }
    let (before, share) = locate(index, frames.len());
    let (a, b) = (&frames[before], &frames[(before + 1).min(frames.len() - 1)]);
    if share == 0.0 {
        out.clone_from(a);
        return;
    }
    out.root_position = a.root_position.lerp(&b.root_position, share);
    out.root_orientation = slerp(&a.root_orientation, &b.root_orientation, share);
    out.linear_velocity_w = a.linear_velocity_w.lerp(&b.linear_velocity_w, share);
    out.angular_velocity_w = a.angular_velocity_w.lerp(&b.angular_velocity_w, share);
    blend(&a.joint_positions, &b.joint_positions, share, &mut out.joint_positions);
    blend(&a.joint_velocities, &b.joint_velocities, share, &mut out.joint_velocities);
    out.effectors_w.clear();
    out.effectors_w.extend(a.effectors_w.iter().zip(&b.effectors_w).map(|(a, b)| a.lerp(b, share)));
}

fn blend(a: &[f64], b: &[f64], share: f64, out: &mut Vec<f64>) {
    out.clear();
    out.extend(a.iter().zip(b).map(|(a, b)| a + (b - a) * share));
}

fn unfit(clip: &MotionClip, message: String) -> MotionError {
    MotionError::Unfit { clip: clip.name.clone(), message }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::clip::Provenance;
    use lifelike_character::Vec3;
    use lifelike_character::rotation::{from_wxyz, to_wxyz};

    fn clip() -> MotionClip {
        MotionClip {
            name: "c".into(),
            fps: 10.0,
            joint_names: vec!["a".into(), "b".into()],
            root_position: vec![Vec3::zeros(), Vec3::new(1.0, 2.0, 3.0), Vec3::new(3.0, 2.0, 1.0)],
            root_orientation: vec![
                Quat::identity(),
                Quat::from_euler_angles(0.0, 0.0, 1.0),
                Quat::from_euler_angles(0.0, 0.0, 2.0),
            ],
            joints: vec![0.0, 1.0, 1.0, -1.0, 2.0, 0.0],
            contacts: Some(Contacts { names: vec!["l".into()], flags: vec![true, false, true] }),
            cyclic: false,
            provenance: Provenance::default(),
        }
    }

    #[test]
    fn twice_the_rate_puts_the_middle_between() {
        let out = resample(&clip(), 20.0).unwrap();
        assert_eq!(out.len(), 5);
        assert_eq!(out.root_position[1], Vec3::new(0.5, 1.0, 1.5));
        assert_eq!(out.joints_at(3), [1.5, -0.5]);
        assert!(out.root_orientation[3].angle_to(&Quat::from_euler_angles(0.0, 0.0, 1.5)) < 1e-12);
        assert_eq!(out.root_position[4], clip().root_position[2], "the frames themselves stay");
        assert_eq!(out.contacts.unwrap().flags, [true, false, false, true, true], "the nearer frame, halves go later");
    }

    #[test]
    fn a_lower_rate_keeps_what_is_there_and_drops_the_rest() {
        let out = resample(&clip(), 7.0).unwrap();
        // 0.2 s at 7 Hz: instants 0 and 1/7 s; 2/7 s is beyond the end.
        assert_eq!(out.len(), 2);
        assert!((out.root_position[1].x - (1.0 + 2.0 * 3.0 / 7.0)).abs() < 1e-12);
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
            assert!(matches!(resample(&clip(), bad), Err(MotionError::Unfit { .. })), "{bad}");
        }
    }

    #[test]
    fn slerp_agrees_with_scipy() {
        // scipy 1.x: Slerp([0, 1], Rotation.from_quat([[.1,.2,.3,.9],[-.5,.1,-.7,.2]]))(0.3), as xyzw.
        let a = from_wxyz([0.9, 0.1, 0.2, 0.3]).unwrap();
        let b = from_wxyz([0.2, -0.5, 0.1, -0.7]).unwrap();
        let expected: [f64; 4] = [0.7051662155328629, 0.33476491452864476, 0.12942561272804826, 0.6114916771646679];
        let got = to_wxyz(&slerp(&a, &b, 0.3));
        let sign = (got[0] * expected[0]).signum();
        for (g, e) in got.iter().zip(expected) {
            assert!((g * sign - e).abs() < 1e-12, "{got:?} {expected:?}");
        }
        assert_eq!(slerp(&a, &b, 0.0), a);
        assert_eq!(slerp(&a, &b, 1.0), b);
    }

    #[test]
    fn times_outside_are_the_ends_and_rounding_blends_nothing() {
        assert_eq!(locate(-3.0, 5), (0, 0.0));
        assert_eq!(locate(f64::NAN, 5), (0, 0.0));
        assert_eq!(locate(9.0, 5), (4, 0.0));
        assert_eq!(locate(2.999_999_999_99, 5), (3, 0.0));
        assert_eq!(locate(2.5, 5), (2, 0.5));
    }
}
