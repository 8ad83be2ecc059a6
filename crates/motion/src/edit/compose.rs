//! Spatial composition (thesis fig. 4.6): the body from one clip, the arms from another.

use super::joints::{columns, like};
use super::story::{captions, provenance, unfit};
use crate::clip::MotionClip;
use crate::error::MotionError;
use crate::keyframes::curve::minimum_jerk;
use crate::resample::locate;

/// Behaviour where the other clip is over before the base.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Length {
    /// The result ends there.
    Cut,
    /// Its last pose is held to the end of the base.
    Hold,
    /// It is repeated; it must be cyclic.
    Loop,
    /// The joints go back to the base's own, with the fade.
    Return,
}

/// Options of composing.
#[derive(Debug, Clone, PartialEq)]
pub struct Compose {
    /// The joints that are taken from the other clip, by name; see [`joints_of`](super::joints_of).
    pub joints: Vec<String>,
    /// When the other clip begins in the base's time (s). Before 0: it has begun already.
    pub offset: f64,
    /// Behaviour where the other clip is shorter.
    pub length: Length,
    /// Duration of the joints' transition from the base's to the other's (s) and, with [`Length::Return`], back. 0:
    /// abruptly.
    pub fade: f64,
}

/// Returns `base` with some joints from `other`: at the base's rate, with its root, its feet's contacts and all joints
/// that are not named. Outside of the other clip's time the joints are the base's own, unless [`Compose::length`] says
/// otherwise.
///
/// # Errors [`MotionError::Unfit`] for unknown joints, clips that do not meet by the offset, and a fade longer than
/// the other clip. A repeated clip must be cyclic.
pub fn compose(base: &MotionClip, other: &MotionClip, options: &Compose) -> Result<MotionClip, MotionError> {
    let mut out = base.clone();
    let other = &like(base, other)?;
    let columns = columns(base, &options.joints)?;
    let &Compose { offset, length, fade, .. } = options;
    let lasting = other.seconds();
    if !(offset.is_finite() && offset <= base.seconds() && (length != Length::Cut || offset + lasting >= 0.0)) {
        let message = format!(
            "expected it to begin while '{}' lasts ({:.3} s) and not to be over before, got an offset of {offset} s",
            base.name,
            base.seconds()
        );
        return Err(unfit(other, message));
    }
    if !(fade >= 0.0 && fade <= lasting) {
        return Err(unfit(other, format!("expected a fade of 0 to {lasting:.3} s, its length, got {fade} s")));
    }
    if length == Length::Loop && !(other.cyclic && lasting > 0.0) {
        return Err(unfit(other, "expected a cyclic clip to repeat, got one that is not".into()));
    }
    if length == Length::Cut {
        let frames = ((offset + lasting) * base.fps + 1e-6).floor() as usize + 1;
        out = super::trim(base, None, Some((frames.min(base.len()) - 1) as f64 / base.fps))?;
    }
    let width = out.joint_names.len();
    for t in 0..out.len() {
        let time = t as f64 / base.fps - offset;
        let weight = weight(time, lasting, length, fade);
        if weight == 0.0 {
            continue;
        }
        let time = if length == Length::Loop && time > lasting { time % lasting } else { time };
        let (before, share) = locate(time * other.fps, other.len());
        let (a, b) = (other.joints_at(before), other.joints_at((before + 1).min(other.len() - 1)));
        for &c in &columns {
            let value = a[c] + share * (b[c] - a[c]);
            let own = &mut out.joints[t * width + c];
            *own = if weight == 1.0 { value } else { *own + weight * (value - *own) };
        }
    }
    out.name = format!("{}+{}", base.name, other.name);
    // The end of the base must meet its beginning in the other clip too: after whole cycles of it.
    let cycles = base.seconds() / lasting.max(1e-9);
    let whole = (cycles - cycles.round()).abs() * lasting * base.fps < 0.5 && cycles > 0.5;
    let steady = length == Length::Loop && fade == 0.0 && offset <= 0.0 && whole;
    out.cyclic = base.cyclic && out.len() == base.len() && steady;
    let mut told = captions(base, out.seconds(), |t| t);
    told.extend(captions(other, out.seconds(), |t| t + offset));
    let done = format!("'{}' with {} of '{}' from {offset} s on", base.name, options.joints.join(", "), other.name);
    out.provenance = provenance(&[base, other], done, told);
    Ok(out)
}

/// Returns the weight of the other clip at this time since its start (s).
fn weight(time: f64, lasting: f64, length: Length, fade: f64) -> f64 {
    // Frames stand at rounded times.
    const ROUNDING: f64 = 1e-9;
    let ramp = |since: f64| match since {
        s if s < -ROUNDING => 0.0,
        s if fade > 0.0 => minimum_jerk(s / fade),
        _ => 1.0,
    };
    let over = if length == Length::Return { ramp(lasting - time) } else { 1.0 };
    ramp(time).min(over)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::fixtures::clip;

    fn options(length: Length, offset: f64, fade: f64) -> Compose {
        Compose { joints: vec!["hinge".into()], offset, length, fade }
    }

    #[test]
    fn named_joints_are_the_others_and_the_rest_the_bases() {
        let (base, other) = (clip(51, |t| [t, 5.0]), clip(26, |t| [10.0 + t, 7.0]));
        let of = |length, offset| compose(&base, &other, &options(length, offset, 0.0)).unwrap();
        let cut = of(Length::Cut, 0.2);
        // 0.2 s and half a second: frames 0 to 35.
        assert_eq!(cut.len(), 36);
        assert_eq!((cut.joints_at(9), cut.joints_at(10)), (&[0.18, 5.0][..], &[10.0, 5.0][..]));
        let held = of(Length::Hold, 0.2);
        assert_eq!((held.len(), held.joints_at(50)[0]), (51, 10.5));
        let back = of(Length::Return, 0.2);
        assert_eq!((back.joints_at(35)[0], back.joints_at(36)[0]), (10.5, 0.72));
        assert!((of(Length::Cut, -0.3).joints_at(0)[0] - 10.3).abs() < 1e-12, "it has begun already");
        assert!(compose(&base, &other, &options(Length::Loop, 0.0, 0.0)).unwrap_err().to_string().contains("cyclic"));
    }

    #[test]
    fn cycles_repeat_and_fades_are_half_way_in_the_middle() {
        let base = clip(101, |_| [0.0, 0.0]);
        let mut other = clip(26, |t| [1.0 + (t * std::f64::consts::TAU / 0.5).sin(), 0.0]);
        other.cyclic = true;
        let out = compose(&base, &other, &options(Length::Loop, 0.0, 0.0)).unwrap();
        assert!((out.joints_at(7)[0] - out.joints_at(82)[0]).abs() < 1e-9, "three cycles later");
        let faded = compose(&base, &clip(51, |_| [2.0, 0.0]), &options(Length::Return, 0.5, 0.4)).unwrap();
        let at = |frame| faded.joints_at(frame)[0];
        assert!((at(35) - 1.0).abs() < 1e-9 && (at(65) - 1.0).abs() < 1e-9, "{} {}", at(35), at(65));
        assert_eq!((at(25), at(50), at(76)), (0.0, 2.0, 0.0));
    }

    #[test]
    fn clips_that_do_not_meet_are_refused() {
        let (base, other) = (clip(51, |_| [0.0, 0.0]), clip(26, |_| [0.0, 0.0]));
        for (offset, fade) in [(1.1, 0.0), (-0.6, 0.0), (f64::NAN, 0.0), (0.0, 0.6), (0.0, -1.0)] {
            assert!(compose(&base, &other, &options(Length::Cut, offset, fade)).is_err(), "{offset} {fade}");
        }
    }
}
