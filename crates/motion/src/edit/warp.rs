//! The same motion at other times: faster, slower, or with its events where they are wanted.

use super::monotone::Monotone;
use super::story::{captions, provenance, unfit};
use crate::clip::MotionClip;
use crate::error::MotionError;
use crate::resample::at_frames;

/// A change of time.
#[derive(Debug, Clone, PartialEq)]
pub enum Warp {
    /// So many times as fast.
    Speed(f64),
    /// Pairs of times (s): the motion at the first is moved to the second. Between them time runs smoothly and
    /// never backwards. The start stays where it is and the rest goes on at its own pace, unless a pair names them.
    Keys(Vec<(f64, f64)>),
}

/// The longest result (s): a day of frames would be a mistake.
const SECONDS_MAX: f64 = 3600.0;

/// Returns the clip at other times, at its own rate: poses are what they were, only their times change. A cyclic clip
/// stays so at a constant speed.
///
/// # Errors
/// [`MotionError::Unfit`] for a speed that is not positive, keys outside of the clip or that do not rise, or a result
/// longer than an hour.
pub fn warp(clip: &MotionClip, how: &Warp) -> Result<MotionClip, MotionError> {
    clip.check()?;
    let seconds = clip.seconds();
    let curve = match how {
        Warp::Speed(speed) if speed.is_finite() && *speed > 0.0 => Monotone::new(&[(0.0, 0.0), (1.0 / speed, 1.0)]),
        Warp::Speed(speed) => return Err(unfit(clip, format!("expected a positive speed, got {speed}"))),
        // The curve gives the time in the clip for a time in the result.
        Warp::Keys(keys) => {
            let keys = complete(clip, keys)?;
            Monotone::new(&keys.iter().map(|(from, to)| (*to, *from)).collect::<Vec<_>>())
        }
    };
    let lasting = curve.inverse(seconds);
    if lasting > SECONDS_MAX {
        return Err(unfit(clip, format!("expected a result of at most {SECONDS_MAX} s, got {lasting:.0} s")));
    }
    let frames = (lasting * clip.fps + 1e-6).floor() as usize + 1;
    let mut out = at_frames(clip, clip.fps, (0..frames).map(|i| curve.at(i as f64 / clip.fps) * clip.fps));
    let done = match how {
        Warp::Speed(speed) => format!("'{}' {speed} times as fast", clip.name),
        Warp::Keys(keys) => {
            let moved: Vec<String> = keys.iter().map(|(from, to)| format!("{from} s at {to} s")).collect();
            format!("'{}' with {}", clip.name, moved.join(", "))
        }
    };
    out.cyclic = clip.cyclic && matches!(how, Warp::Speed(_));
    out.provenance = provenance(&[clip], done, captions(clip, out.seconds(), |t| curve.inverse(t)));
    Ok(out)
}

/// Returns the keys with the clip's start and end.
fn complete(clip: &MotionClip, keys: &[(f64, f64)]) -> Result<Vec<(f64, f64)>, MotionError> {
    let seconds = clip.seconds();
    let mut all = keys.to_vec();
    if let Some((from, to)) = keys.iter().find(|(from, to)| !((0.0..=seconds).contains(from) && to.is_finite())) {
        let message = format!("expected times in its {seconds:.3} s, got a key from {from} s to {to} s");
        return Err(unfit(clip, message));
    }
    match keys {
        [] => return Err(unfit(clip, "expected at least one key (time in, time out), got none".into())),
        [first, .., last] | [first @ last] => {
            if first.0 > 0.0 {
                all.insert(0, (0.0, 0.0));
            } else if first.1 != 0.0 {
                return Err(unfit(clip, format!("expected its start at 0 s, got a key that puts it at {} s", first.1)));
            }
            if last.0 < seconds {
                all.push((seconds, last.1 + seconds - last.0));
            }
        }
    }
    if all.len() < 2 {
        return Err(unfit(clip, "expected a clip of more than one frame".into()));
    }
    for pair in all.windows(2) {
        let ((a, b), (c, d)) = (pair[0], pair[1]);
        if !(c > a && d > b) {
            let message = format!(
                "expected keys that rise in both times, got {a} s -> {b} s before {c} s -> {d} s: time would stand \
                 still or run backwards"
            );
            return Err(unfit(clip, message));
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::fixtures::clip;

    #[test]
    fn twice_as_fast_is_every_other_frame() {
        let mut c = clip(51, |t| [t, 0.0]);
        c.cyclic = true;
        c.provenance.captions = vec![crate::Caption { start: 0.2, end: 1.0, text: "x".into() }];
        let out = warp(&c, &Warp::Speed(2.0)).unwrap();
        assert_eq!((out.len(), out.fps, out.cyclic), (26, 50.0, true));
        assert!((0..26).all(|t| (out.joints_at(t)[0] - 0.04 * t as f64).abs() < 1e-9));
        let told = &out.provenance.captions[0];
        assert!((told.start - 0.1).abs() < 1e-9 && (told.end - 0.5).abs() < 1e-9);
        assert_eq!(warp(&c, &Warp::Speed(1.0)).unwrap().joints, c.joints);
    }

    #[test]
    fn events_are_at_their_new_times_and_the_rest_goes_on() {
        let c = clip(101, |t| [t, 0.0]);
        let out = warp(&c, &Warp::Keys(vec![(0.5, 0.8), (1.0, 1.0)])).unwrap();
        assert!((out.joints_at(40)[0] - 0.5).abs() < 1e-9 && (out.joints_at(50)[0] - 1.0).abs() < 1e-9);
        assert_eq!(out.len(), 101);
        assert!((1..101).all(|t| out.joints_at(t)[0] > out.joints_at(t - 1)[0]));
        let late = warp(&c, &Warp::Keys(vec![(1.0, 1.5)])).unwrap();
        assert_eq!(late.len(), 126, "half a second longer");
        let whole = warp(&c, &Warp::Keys(vec![(0.0, 0.0), (2.0, 3.0)])).unwrap();
        assert!(whole.len() == 151 && (whole.joints_at(75)[0] - 1.0).abs() < 1e-9, "two keys are a constant speed");
    }

    #[test]
    fn time_does_not_run_backwards() {
        let c = clip(101, |t| [t, 0.0]);
        let message = warp(&c, &Warp::Keys(vec![(0.5, 0.8), (1.0, 0.7)])).unwrap_err().to_string();
        assert!(message.contains("0.5 s -> 0.8 s before 1 s -> 0.7 s"), "{message}");
        let bad = [vec![], vec![(2.5, 1.0)], vec![(0.5, -0.1)], vec![(0.0, 1.0)], vec![(1.0, 1.0), (0.5, 2.0)]];
        assert!(bad.into_iter().all(|keys| warp(&c, &Warp::Keys(keys)).is_err()));
        for speed in [0.0, -1.0, f64::NAN, 1e-9] {
            assert!(warp(&c, &Warp::Speed(speed)).is_err(), "{speed}");
        }
    }
}
