//! A stretch of a clip.

use super::story::{captions, provenance, unfit};
use crate::clip::{Contacts, MotionClip};
use crate::error::MotionError;

/// Returns the frames from `start` to `end` (s; the ends of the clip where not given), both included, at the place
/// where they are. Times that lie between two frames go inwards. The whole of a cyclic clip stays cyclic.
///
/// # Errors
/// [`MotionError::Unfit`] for times that are not in the clip, or no frame between them.
pub fn trim(clip: &MotionClip, start: Option<f64>, end: Option<f64>) -> Result<MotionClip, MotionError> {
    clip.check()?;
    let seconds = clip.seconds();
    let (from, to) = (start.unwrap_or(0.0), end.unwrap_or(seconds));
    // A time as it is printed may lie a little beyond the last frame.
    const ROUNDING: f64 = 1e-6;
    if !(from >= 0.0 && to <= seconds + ROUNDING && from <= to) {
        let message = format!("expected 0 <= start <= end <= {seconds:.3} s, got {from} to {to} s");
        return Err(unfit(clip, message));
    }
    let first = (from * clip.fps - ROUNDING).ceil().max(0.0) as usize;
    let last = ((to * clip.fps + ROUNDING).floor() as usize).min(clip.len() - 1);
    if first > last {
        return Err(unfit(clip, format!("expected a frame from {from} to {to} s, got none at {} Hz", clip.fps)));
    }
    let whole = first == 0 && last == clip.len() - 1;
    let width = clip.joint_names.len();
    let shift = first as f64 / clip.fps;
    let done = format!("'{}' from {shift:.3} to {:.3} s", clip.name, last as f64 / clip.fps);
    let told = captions(clip, (last - first) as f64 / clip.fps, |t| t - shift);
    Ok(MotionClip {
        name: clip.name.clone(),
        fps: clip.fps,
        joint_names: clip.joint_names.clone(),
        root_position: clip.root_position[first..=last].to_vec(),
        root_orientation: clip.root_orientation[first..=last].to_vec(),
        joints: clip.joints[first * width..(last + 1) * width].to_vec(),
        contacts: clip.contacts.as_ref().map(|c| {
            let places = c.names.len();
            Contacts { names: c.names.clone(), flags: c.flags[first * places..(last + 1) * places].to_vec() }
        }),
        cyclic: clip.cyclic && whole,
        provenance: if whole { clip.provenance.clone() } else { provenance(&[clip], done, told) },
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::fixtures::clip;

    #[test]
    fn frames_between_the_times_are_kept() {
        let mut c = clip(51, |t| [t, 0.0]);
        c.cyclic = true;
        let out = trim(&c, Some(0.05), Some(0.5)).unwrap();
        // 0.05 s lies between frames 2 and 3 at 50 Hz.
        assert_eq!((out.len(), out.joints_at(0)[0], out.joints_at(22)[0]), (23, 0.06, 0.5));
        assert!(!out.cyclic && trim(&c, None, None).unwrap().cyclic);
        assert_eq!(trim(&c, Some(1.0), None).unwrap().len(), 1);
        for (a, b) in [(-0.1, 0.5), (0.5, 0.4), (0.0, 1.1), (0.011, 0.012), (f64::NAN, 0.5)] {
            assert!(trim(&c, Some(a), Some(b)).is_err(), "{a} {b}");
        }
    }
}
