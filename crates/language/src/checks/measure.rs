//! Numbers of a motion: peaks, steps, energies, durations.

use lifelike_character::Vec3;

use super::tracks::{SignalName, Tracks, range};
use crate::facts::{Nominal, Side};
use crate::grammar::{Acts, CountRule, Tempo, Verb};

/// Share of a signal's range by which it turns around at a peak.
const TURN: f64 = 0.1;
/// Share of the greatest difference between neighbouring peak and valley that every one has.
const SWING_SHARE: f64 = 0.4;
/// Share of the highest flight below which one is a bounce.
const BOUNCE: f64 = 0.4;
/// Share of the greatest speed that counts as movement.
const MOVING: f64 = 0.08;

/// Returns the frames of the peaks of a signal inside of its gate.
///
/// A peak and the valley beside it differ by [`TURN`] of the signal's range at least, and by [`SWING_SHARE`] of the
/// greatest difference between neighbours: the way to the first peak and from the last does not count. So a small
/// movement at the end of a long reach is seen.
pub fn peaks(values: &[f64], gate: &[bool]) -> Vec<usize> {
    let frames: Vec<usize> = (0..values.len()).filter(|frame| gate[*frame]).collect();
    let inside: Vec<f64> = frames.iter().map(|frame| values[*frame]).collect();
    let Some((low, high)) = range(&inside).filter(|(low, high)| high - low > 1e-6) else { return Vec::new() };
    let all = turns(&inside, TURN * (high - low));
    let inner = all.windows(2).map(|pair| (inside[pair[0]] - inside[pair[1]]).abs());
    let kept = match inner.reduce(f64::max) {
        Some(greatest) => turns(&inside, (SWING_SHARE * greatest).max(TURN * (high - low))),
        None => all,
    };
    let edge = TURN * (high - low);
    let ends = [inside.first(), inside.last()].map(|v| v.copied().unwrap_or(0.0));
    let peaks: Vec<usize> = kept.into_iter().step_by(2).collect();
    let (first, last) = (peaks.first().copied(), peaks.last().copied());
    // Where the signal only comes from, or goes to, what is outside of the gate, there is no peak.
    let counts = |at: &usize| {
        !(Some(*at) == first && inside[*at] - ends[0] < edge || Some(*at) == last && inside[*at] - ends[1] < edge)
    };
    peaks.into_iter().filter(counts).map(|at| frames[at]).collect()
}

/// Returns the places where a signal turns around by more than `least`: peak, valley, peak, ..., peak.
fn turns(values: &[f64], least: f64) -> Vec<usize> {
    let mut found: Vec<usize> = Vec::new();
    let (mut top, mut bottom) = (0, 0);
    let mut rising = true;
    for at in 1..values.len() {
        if rising {
            if values[at] > values[top] {
                top = at;
            } else if values[top] - values[at] > least {
                found.push(top);
                (rising, bottom) = (false, at);
            }
        } else if values[at] < values[bottom] {
            bottom = at;
        } else if values[at] - values[bottom] > least {
            found.push(bottom);
            (rising, top) = (true, at);
        }
    }
    // A rise at the end of the gate is a peak too: the limb goes down from there.
    if rising {
        found.push(top);
    } else if found.len().is_multiple_of(2) {
        found.pop();
    }
    found
}

/// Returns the swings of a foot: frames from leaving the ground to standing on it.
pub fn swings(tracks: &Tracks, foot: usize) -> Vec<(usize, usize)> {
    let path = &tracks.feet[foot];
    let Some((low, _)) = range(&path.iter().map(|p| p.z).collect::<Vec<_>>()) else { return Vec::new() };
    let (on, off) = (low + tracks.lift * tracks.leg, low + 0.5 * tracks.lift * tracks.leg);
    let mut found = Vec::new();
    let mut since = None;
    for (frame, p) in path.iter().enumerate() {
        match since {
            None if p.z > on => since = Some(frame),
            Some(start) if p.z < off => {
                found.push((start, frame));
                since = None;
            }
            _ => {}
        }
    }
    found
}

/// Returns the longest time in which a foot stays off the ground (s); of both feet, that of either.
pub fn held_up(tracks: &Tracks, side: Option<Side>) -> f64 {
    let feet = match side {
        Some(Side::Left) => 0..1,
        Some(Side::Right) => 1..2,
        _ => 0..2,
    };
    let longest = feet.flat_map(|foot| swings(tracks, foot)).map(|(from, to)| to - from).max();
    longest.unwrap_or(0) as f64 / tracks.fps
}

/// Returns the number of times that no foot is on the ground. A bounce after a landing is no flight.
pub fn flights(tracks: &Tracks) -> usize {
    let mut up = vec![0; tracks.len()];
    for foot in 0..2 {
        for (start, end) in swings(tracks, foot) {
            up[start..end].iter_mut().for_each(|feet| *feet += 1);
        }
    }
    let height = |frame: usize| tracks.feet[0][frame].z.min(tracks.feet[1][frame].z);
    let floor = (0..up.len()).map(height).fold(f64::INFINITY, f64::min);
    let mut heights: Vec<f64> = Vec::new();
    let mut was_up = false;
    for (frame, feet) in up.iter().enumerate() {
        let is_up = *feet == 2;
        match heights.last_mut().filter(|_| was_up) {
            Some(highest) if is_up => *highest = highest.max(height(frame) - floor),
            None if is_up => heights.push(height(frame) - floor),
            _ => {}
        }
        was_up = is_up;
    }
    let highest = heights.iter().copied().fold(0.0, f64::max);
    heights.iter().filter(|height| **height >= BOUNCE * highest).count()
}

/// Returns the number of steps. The last one does not count where it only brings the feet together again.
pub fn steps(tracks: &Tracks) -> usize {
    let swings = [swings(tracks, 0), swings(tracks, 1)].concat();
    let all = swings.len();
    // From foot to foot as the body sees it.
    let between = |frame: usize| {
        let way = ground(&(tracks.feet[0][frame] - tracks.feet[1][frame]));
        let (sin, cos) = tracks.yaw[frame].sin_cos();
        Vec3::new(cos * way.x + sin * way.y, cos * way.y - sin * way.x, 0.0)
    };
    let frames = tracks.feet[0].len().min(tracks.feet[1].len());
    if frames == 0 {
        return all;
    }
    // Where a foot comes down, not where one is swung about in the air.
    let off = |frame: usize| (between(frame) - between(0)).norm();
    let widest = swings.iter().map(|(_, end)| off((*end).min(frames - 1))).fold(0.0, f64::max);
    let closes = widest > 0.1 * tracks.leg && off(frames - 1) < 0.5 * widest;
    if closes { all.saturating_sub(1) } else { all }
}

/// Returns a vector's part along the ground.
pub fn ground(v: &Vec3) -> Vec3 {
    Vec3::new(v.x, v.y, 0.0)
}

/// Returns the distance along the ground from where the root begins to where it ends (m).
pub fn way(tracks: &Tracks) -> f64 {
    tracks.root.first().zip(tracks.root.last()).map_or(0.0, |(first, last)| ground(&(last - first)).norm())
}

/// Returns the width of the root's way along the ground (m): that of a circle is its diameter.
pub fn wide(tracks: &Tracks) -> f64 {
    let places = || tracks.root.iter().step_by(5).map(ground);
    places().flat_map(|a| places().map(move |b| (a - b).norm())).fold(0.0, f64::max)
}

/// Returns the energy of a path: the mean square of its speed (m²/s²).
pub fn energy(path: &[Vec3], fps: f64) -> f64 {
    let steps = path.windows(2).map(|w| ((w[1] - w[0]) * fps).norm_squared());
    steps.sum::<f64>() / path.len().max(2) as f64
}

/// Returns the farthest that a path is from its start (m).
pub fn excursion(path: &[Vec3]) -> f64 {
    let Some(first) = path.first() else { return 0.0 };
    path.iter().map(|p| (p - first).norm()).fold(0.0, f64::max)
}

/// Returns the count that a rule gives; none where the robot lacks the limb.
pub fn count(tracks: &Tracks, rule: &CountRule, side: Option<Side>) -> Option<usize> {
    if rule.signal == SignalName::Steps {
        return Some(steps(tracks));
    }
    if rule.signal == SignalName::PairsOfSteps {
        return Some(swings(tracks, 0).len().max(swings(tracks, 1).len()));
    }
    if rule.signal == SignalName::Flights {
        return Some(flights(tracks).saturating_sub(rule.minus as usize));
    }
    let (values, gate) = tracks.signal(rule.signal, side)?;
    Some(peaks(&values, &gate).len().saturating_sub(rule.minus as usize))
}

/// Returns the tempo of an action (see [`Nominal::tempo`]); none where it does not show.
pub fn tempo(tracks: &Tracks, verb: &Verb, side: Option<Side>) -> Option<f64> {
    match verb.tempo {
        Tempo::Period => {
            let (values, gate) = tracks.signal(verb.count?.signal, side)?;
            let peaks = peaks(&values, &gate);
            let (first, last) = (peaks.first()?, peaks.last()?);
            (peaks.len() > 1).then(|| (last - first) as f64 / tracks.fps / (peaks.len() - 1) as f64)
        }
        // Of what repeats, one repetition: how often is another question.
        Tempo::Duration if verb.cycle.is_some() => match verb.count {
            Some(_) => between_steps(tracks),
            None => swinging(tracks, verb),
        },
        Tempo::Duration => active(tracks),
        Tempo::Pace => {
            let way: Vec<f64> = tracks
                .root
                .windows(2)
                .scan(0.0, |sum, w| {
                    *sum += ground(&(w[1] - w[0])).norm();
                    Some(*sum)
                })
                .collect();
            let whole = *way.last()?;
            let at = |share: f64| way.iter().position(|w| *w >= share * whole);
            let (from, to) = (at(0.2)?, at(0.8)?);
            (to > from && whole > 0.1 * tracks.leg).then(|| (way[to] - way[from]) * tracks.fps / (to - from) as f64)
        }
    }
}

/// Returns the mean time from step to step (s).
fn between_steps(tracks: &Tracks) -> Option<f64> {
    let mut begins: Vec<usize> = (0..2).flat_map(|foot| swings(tracks, foot)).map(|(from, _)| from).collect();
    begins.sort_unstable();
    let (first, last) = (begins.first()?, begins.last()?);
    (begins.len() > 2).then(|| (last - first) as f64 / tracks.fps / (begins.len() - 1) as f64)
}

/// Returns the period (s) of the coordinate of the acting part that turns around most often by as much as the others: of
/// hands, or of the pelvis.
fn swinging(tracks: &Tracks, verb: &Verb) -> Option<f64> {
    let paths: Vec<&[Vec3]> = match verb.acts {
        Acts::Hand | Acts::Hands => tracks.hands.iter().map(Vec::as_slice).collect(),
        Acts::Body => vec![&tracks.root],
        Acts::Feet | Acts::Foot => tracks.feet.iter().map(Vec::as_slice).collect(),
        Acts::Head => return None,
    };
    let mut best: Option<(f64, f64)> = None;
    for path in paths {
        for axis in 0..3 {
            let values: Vec<f64> = path.iter().map(|p| p[axis]).collect();
            let tops = peaks(&values, &vec![true; values.len()]);
            let (Some(first), Some(last)) = (tops.first(), tops.last()) else { continue };
            let Some((low, high)) = range(&values[*first..=*last]).filter(|_| tops.len() > 1) else { continue };
            let period = (last - first) as f64 / tracks.fps / (tops.len() - 1) as f64;
            if best.is_none_or(|(swing, _)| high - low > swing) {
                best = Some((high - low, period));
            }
        }
    }
    best.map(|(_, period)| period)
}

/// Returns the time from the first to the last movement (s) of anything: hands, feet, head or root.
fn active(tracks: &Tracks) -> Option<f64> {
    let points = [&tracks.hands[0], &tracks.hands[1], &tracks.feet[0], &tracks.feet[1], &tracks.root];
    let mut speed = vec![0.0_f64; tracks.len().saturating_sub(1)];
    for path in points {
        for (sum, w) in speed.iter_mut().zip(path.windows(2)) {
            *sum += (w[1] - w[0]).norm();
        }
    }
    for (sum, w) in speed.iter_mut().zip(tracks.head.windows(2)) {
        *sum += 0.3 * tracks.leg * (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1]);
    }
    let (_, fastest) = range(&speed)?;
    let moves = |v: &f64| *v > MOVING * fastest;
    let (first, last) = (speed.iter().position(moves)?, speed.iter().rposition(moves)?);
    (last > first).then(|| (last - first) as f64 / tracks.fps)
}

/// Returns how far the head turns, or how far the trunk leans and sinks (rad; a leg's length counts as one).
fn inclined(tracks: &Tracks, verb: &Verb) -> f64 {
    let far = |values: Vec<f64>| range(&values).map_or(0.0, |(low, high)| high - low);
    if verb.acts == Acts::Head {
        let turn = |which: usize| far(tracks.head.iter().map(|head| head[which]).collect());
        return turn(0).hypot(turn(1));
    }
    let sunk = far(tracks.root.iter().map(|p| p.z).collect()) / tracks.leg;
    far(tracks.pitch.clone()).hypot(far(tracks.lean.clone())).hypot(sunk)
}

/// Returns the range of the verb's signal; none where it has none.
pub fn amplitude(tracks: &Tracks, verb: &Verb, side: Option<Side>) -> Option<f64> {
    let Some(signal) = verb.amplitude() else { return verb.is_inclined().then(|| inclined(tracks, verb)) };
    if matches!(signal, SignalName::Steps | SignalName::PairsOfSteps) {
        let apart = tracks.feet[0].iter().zip(&tracks.feet[1]).map(|(a, b)| ground(&(a - b)).norm());
        let apart: Vec<f64> = apart.collect();
        let (_, high) = range(&apart)?;
        return Some((high.powi(2) - apart.first()?.powi(2)).max(0.0).sqrt());
    }
    if signal == SignalName::Flights {
        let lower = tracks.feet[0].iter().zip(&tracks.feet[1]).map(|(a, b)| a.z.min(b.z));
        let (low, high) = range(&lower.collect::<Vec<_>>())?;
        return Some(high - low);
    }
    let (values, gate) = tracks.signal(signal, side)?;
    // Of the repetitions only: not of the way there.
    let tops = peaks(&values, &gate);
    let inside: Vec<f64> = match (tops.first(), tops.last()) {
        (Some(a), Some(b)) if b > a => values[*a..=*b].to_vec(),
        _ => values.iter().zip(&gate).filter(|(_, g)| **g).map(|(v, _)| *v).collect(),
    };
    let (low, high) = range(&inside)?;
    Some(high - low)
}

/// Returns the largest change of the chest's pitch from the first frame (degrees); of the root's without a chest.
pub fn bent(tracks: &Tracks) -> f64 {
    let pitch = if tracks.chest.is_empty() { &tracks.pitch } else { &tracks.chest };
    let first = pitch.first().copied().unwrap_or(0.0);
    pitch.iter().map(|value| (value - first).abs()).fold(0.0, f64::max).to_degrees()
}

/// Returns the mean pitch of the head (rad), of the chest without a head, or of the root without both, over the middle
/// three fifths.
pub fn head_pitch(tracks: &Tracks) -> f64 {
    let n = tracks.len();
    let middle = n / 5..(n - n / 5).max(n / 5 + 1).min(n);
    let pitch = |frame: usize| match (tracks.head.get(frame), tracks.chest.get(frame)) {
        (Some(head), _) => head[0],
        (None, Some(chest)) => *chest,
        (None, None) => tracks.pitch[frame],
    };
    let len = middle.len().max(1) as f64;
    middle.map(pitch).sum::<f64>() / len
}

/// Returns what is normal of an action, measured on it as it is normally.
pub fn nominal(tracks: &Tracks, verb: &Verb, side: Option<Side>) -> Nominal {
    Nominal {
        tempo: tempo(tracks, verb, side).unwrap_or(0.0),
        amplitude: amplitude(tracks, verb, side).unwrap_or(0.0),
        head_pitch: head_pitch(tracks),
    }
}
