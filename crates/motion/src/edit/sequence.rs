//! Clips one after the other, each from where the one before it ended.

use super::blend::{common_contacts, comparable, mix, mixed_step};
use super::joints::like;
use super::path::{Stand, continuous, lay};
use super::story::{captions, provenance, unfit};
use super::trim::trim;
use crate::clip::{Contacts, MotionClip};
use crate::error::MotionError;
use crate::keyframes::curve::minimum_jerk;

/// A clip, or a stretch of it.
#[derive(Debug, Clone, Copy)]
pub struct Part<'a> {
    /// The clip.
    pub clip: &'a MotionClip,
    /// From here (s); its start where not given.
    pub start: Option<f64>,
    /// To here (s); its end where not given.
    pub end: Option<f64>,
}

impl<'a> From<&'a MotionClip> for Part<'a> {
    fn from(clip: &'a MotionClip) -> Self {
        Self { clip, start: None, end: None }
    }
}

/// Returns the parts in this order, at the rate of the first.
///
/// A part begins on the ground where the one before it ended and looks where that looked; heights stay. Two neighbours
/// share `fade` seconds, in which joints, height and tilt go over smoothly. The way over the ground is walked at the
/// mixed velocity ([`blend`](mod@super::blend)). With `fade` 0 they share one instant, whose pose is the later one's:
/// an abrupt switch. In a transition a foot stands where it stands in both.
///
/// # Errors
/// [`MotionError::Unfit`] for no part, a stretch that is not in its clip, other joints than the first one's, or a fade
/// longer than a part.
pub fn sequence(parts: &[Part<'_>], fade: f64) -> Result<MotionClip, MotionError> {
    let Some((first, others)) = parts.split_first() else {
        return Err(MotionError::Unfit { clip: "(none)".into(), message: "expected at least one part".into() });
    };
    let mut out = trim(first.clip, first.start, first.end)?;
    if !(fade >= 0.0 && fade.is_finite()) {
        return Err(unfit(&out, format!("expected a fade of 0 s or more, got {fade}")));
    }
    let steps = (fade * out.fps).round() as usize;
    let mut told = out.provenance.captions.clone();
    let mut names = vec![stretch(first)];
    let mut before = out.len();
    for part in others {
        let mut next = like(&out, &trim(part.clip, part.start, part.end)?)?;
        for (clip, frames) in [(out.name.as_str(), before), (next.name.as_str(), next.len())] {
            if steps >= frames {
                let seconds = (frames - 1) as f64 / out.fps;
                let message = format!("a fade of {fade} s does not fit into a part of {seconds:.3} s");
                return Err(MotionError::Unfit { clip: clip.into(), message });
            }
        }
        before = next.len();
        let start = (out.len() - 1 - steps) as f64 / out.fps;
        told.extend(captions(&next, f64::INFINITY, |t| t + start));
        join(&mut out, &mut next, steps);
        names.push(stretch(part));
        out.name = format!("{}+{}", out.name, next.name);
    }
    if others.is_empty() {
        return Ok(out);
    }
    out.cyclic = false;
    let sources: Vec<&MotionClip> = parts.iter().map(|part| part.clip).collect();
    let how = if steps == 0 { "switched abruptly".into() } else { format!("cross-faded over {fade} s") };
    out.provenance = provenance(&sources, format!("{}, {how}", names.join(", then ")), told);
    continuous(&mut out.root_orientation);
    Ok(out)
}

fn stretch(part: &Part<'_>) -> String {
    let time = |time: Option<f64>| time.map_or_else(String::new, |t| t.to_string());
    match (part.start, part.end) {
        (None, None) => format!("'{}'", part.clip.name),
        (start, end) => format!("'{}' {}..{} s", part.clip.name, time(start), time(end)),
    }
}

/// Appends `next` so that its first `steps` steps lie over the last ones of `out`.
fn join(out: &mut MotionClip, next: &mut MotionClip, steps: usize) {
    let from = out.len() - 1 - steps;
    let old = out.clone();
    let mut stand = Stand::of(out, from);
    let share = |k: f64| if steps == 0 { 1.0 } else { minimum_jerk(k / steps as f64) };
    for k in 0..=steps {
        if k > 0 {
            // A step belongs to the middle between its ends.
            stand = stand.after(&mixed_step((&old, from + k), (next, k), share(k as f64 - 0.5)));
        }
        mix(out, from + k, (&old, from + k), (next, k), share(k as f64), &stand);
    }
    lay(next, steps, &stand);
    out.contacts = joined_contacts(&old, next, from, steps);
    let width = out.joint_names.len();
    out.root_position.extend_from_slice(&next.root_position[steps + 1..]);
    out.root_orientation.extend_from_slice(&next.root_orientation[steps + 1..]);
    out.joints.extend_from_slice(&next.joints[(steps + 1) * width..]);
}

fn joined_contacts(old: &MotionClip, next: &MotionClip, from: usize, steps: usize) -> Option<Contacts> {
    let (a, b) = comparable(old, next)?;
    let n = a.names.len();
    let mut flags = a.flags[..from * n].to_vec();
    if steps > 0 {
        let shared = (steps + 1) * n;
        flags.extend(common_contacts(&a.flags[from * n..], &b.flags[..shared]));
    } else {
        flags.extend_from_slice(&b.flags[..n]);
    }
    flags.extend_from_slice(&b.flags[(steps + 1) * n..]);
    Some(Contacts { names: a.names.clone(), flags })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::fixtures::clip;
    use lifelike_character::Vec3;

    fn walk(speed: f64, joint: f64) -> MotionClip {
        let mut c = clip(51, |_| [joint, 0.0]);
        for t in 0..c.len() {
            c.root_position[t] = Vec3::new(speed * t as f64 / c.fps, 3.0, 0.5);
        }
        c.contacts = Some(Contacts { names: vec!["foot".into()], flags: vec![joint > 0.5; 51] });
        c
    }

    #[test]
    fn an_abrupt_switch_changes_one_step() {
        let (a, b) = (walk(1.0, 0.0), walk(1.0, 1.0));
        let out = sequence(&[(&a).into(), (&b).into()], 0.0).unwrap();
        assert_eq!(out.len(), 101);
        let jumps: Vec<usize> = (1..out.len()).filter(|&t| out.joints_at(t)[0] != out.joints_at(t - 1)[0]).collect();
        assert_eq!(jumps, [50]);
        // Both walk at 1 m/s: the way goes on without a seam, two metres in two seconds.
        for t in 1..out.len() {
            assert!((out.root_position[t].x - out.root_position[t - 1].x - 0.02).abs() < 1e-12);
        }
        let flags = out.contacts.unwrap().flags;
        assert!(!flags[49] && flags[50]);
    }

    #[test]
    fn a_fade_from_walking_to_standing_never_goes_back() {
        let (a, b) = (walk(1.0, 0.0), walk(0.0, 1.0));
        let out = sequence(&[(&a).into(), (&b).into()], 0.4).unwrap();
        assert_eq!(out.len(), 51 + 51 - 20 - 1);
        let steps: Vec<f64> = (1..out.len()).map(|t| out.root_position[t].x - out.root_position[t - 1].x).collect();
        assert!(steps.iter().all(|s| (-1e-12..=0.02 + 1e-12).contains(s)), "{steps:?}");
        // Half the speed on the mean over the 0.4 s that are shared: 0.6 m before them, 0.2 m in them.
        assert!((out.root_position[80].x - 0.8).abs() < 1e-9, "{}", out.root_position[80].x);
        assert!((out.joints_at(40)[0] - 0.5).abs() < 1e-12);
        assert_eq!((out.joints_at(30)[0], out.joints_at(50)[0]), (0.0, 1.0));
    }

    #[test]
    fn what_cannot_be_joined_is_told() {
        let a = walk(1.0, 0.0);
        assert!(sequence(&[], 0.0).is_err());
        assert!(sequence(&[(&a).into(), (&a).into()], 1.01).unwrap_err().to_string().contains("1.000 s"));
        assert!(sequence(&[(&a).into(), (&a).into()], f64::NAN).is_err());
        let part = Part { clip: &a, start: Some(0.5), end: Some(2.0) };
        assert!(sequence(&[(&a).into(), part], 0.1).is_err());
        assert_eq!(sequence(&[(&a).into()], 0.0).unwrap(), a);
    }
}
