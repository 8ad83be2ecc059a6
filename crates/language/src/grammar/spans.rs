//! Times of a clip in which it moves, stands still, or is made to.

use lifelike_motion::MotionClip;

use crate::checks::{Tracks, measure};

/// Fastest joint of a pose that is held (rad/s).
const STILL: f64 = 1.0;
/// Most times as fast as it is that a pose is held where it is to be shorter.
const FASTER: usize = 4;

/// Returns the time from where a clip leaves its first pose to where it is nearly as far from it as it goes (s).
pub(super) fn rise_of(clip: &MotionClip) -> Option<f64> {
    let gone = |t: usize| {
        let pairs = clip.joints_at(t).iter().zip(clip.joints_at(0));
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let most = (0..clip.len()).map(gone).fold(0.0, f64::max);
    let at = |share: f64| (0..clip.len()).find(|t| gone(*t) > share * most);
    at(0.95).zip(at(0.05)).map(|(there, left)| (there - left) as f64 / clip.fps)
}

/// Returns the time from the first step to the last one (s).
pub(super) fn walked(tracks: &Tracks) -> f64 {
    let swings = [measure::swings(tracks, 0), measure::swings(tracks, 1)].concat();
    let first = swings.iter().map(|(from, _)| *from).min();
    let last = swings.iter().map(|(_, to)| *to).max();
    first.zip(last).map_or(0.0, |(first, last)| (last - first) as f64 / tracks.fps)
}

/// Returns the longest time in which no joint is faster than [`STILL`] (s), apart from standing before and after.
pub(super) fn still_seconds(clip: &MotionClip) -> f64 {
    let n = clip.len();
    let is_still = |t: usize| {
        let pairs = clip.joints_at(t).iter().zip(clip.joints_at(t + 1));
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) * clip.fps < STILL
    };
    let begin = (0..n.saturating_sub(1)).position(|t| !is_still(t)).unwrap_or(0);
    let end = (0..n.saturating_sub(1)).rposition(|t| !is_still(t)).unwrap_or(0);
    let (mut longest, mut now) = (0, 0);
    for t in begin..end {
        now = if is_still(t) { now + 1 } else { 0 };
        longest = longest.max(now);
    }
    longest as f64 / clip.fps
}

/// Returns the greatest change of a joint from a frame to the next (rad).
fn change(clip: &MotionClip, t: usize) -> f64 {
    let pairs = clip.joints_at(t).iter().zip(clip.joints_at(t + 1));
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Returns the stillest frame of the middle third.
pub(super) fn stillest(clip: &MotionClip) -> Option<usize> {
    let n = clip.len();
    let middle = (n / 3)..(2 * n / 3).min(n.saturating_sub(1));
    middle.min_by(|a, b| change(clip, *a).total_cmp(&change(clip, *b)))
}

/// Returns when a clip has all but reached the pose at its middle (s): from there no joint is faster than [`STILL`].
pub(super) fn reached(clip: &MotionClip) -> f64 {
    let Some(at) = stillest(clip) else { return 0.0 };
    let before = (0..at).rev().take_while(|t| change(clip, *t) * clip.fps < STILL).count();
    (at - before) as f64 / clip.fps
}

/// Holds the pose at the middle of a clip for as long as asked for (s).
pub(super) fn held(clip: &MotionClip, seconds: f64) -> MotionClip {
    let Some(at) = stillest(clip) else { return clip.clone() };
    // Frames around it that are slower than a speed: those that hold the pose already.
    let around = |speed: f64| {
        let slow = |t: &usize| change(clip, *t) * clip.fps < speed;
        let before = (0..at).rev().take_while(slow).count();
        [at - before, at + (at..clip.len().saturating_sub(1)).take_while(slow).count()]
    };
    let [start, end] = around(STILL);
    let (own, wanted) = (end - start, (seconds * clip.fps).round() as usize);
    if wanted >= own {
        return repeated(clip, at, wanted - own);
    }
    // A hold that is longer by itself goes faster where it is slowest, and is still one.
    let [start, end] = around(STILL / FASTER as f64);
    let kept = (end - start).saturating_sub(own - wanted).max((end - start).div_ceil(FASTER));
    let middle = (0..kept).map(|i| start + i * (end - start) / kept);
    taken(clip, &(0..start).chain(middle).chain(end..clip.len()).collect::<Vec<_>>())
}

/// Returns a clip that stays at a frame for some frames more.
pub(super) fn repeated(clip: &MotionClip, at: usize, extra: usize) -> MotionClip {
    let times = |t: usize| if t == at { extra + 1 } else { 1 };
    taken(clip, &(0..clip.len()).flat_map(|t| std::iter::repeat_n(t, times(t))).collect::<Vec<_>>())
}

/// Returns the frames of a clip in an order.
fn taken(clip: &MotionClip, frames: &[usize]) -> MotionClip {
    let joints = clip.joint_names.len();
    let mut out = clip.clone();
    out.root_position = frames.iter().map(|t| clip.root_position[*t]).collect();
    out.root_orientation = frames.iter().map(|t| clip.root_orientation[*t]).collect();
    out.joints = frames.iter().flat_map(|t| clip.joints[t * joints..(t + 1) * joints].iter().copied()).collect();
    if let Some(contacts) = &mut out.contacts {
        let feet = contacts.names.len();
        let flags = contacts.flags.clone();
        contacts.flags = frames.iter().flat_map(|t| flags[t * feet..(t + 1) * feet].iter().copied()).collect();
    }
    out
}
