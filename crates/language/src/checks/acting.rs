//! Which limb acts, what is seen of it, and where the body goes.

use lifelike_character::Vec3;

use super::measure::{bent, energy, excursion, flights, ground, held_up, swings};
use super::tracks::{SignalName, Tracks, range};
use crate::facts::{Direction, Side};
use crate::grammar::{Acts, Limb, Show, Synth, Verb};
use crate::touch::Touch;

/// Share of the energy of both hands or feet that the acting one has at least.
const ACTING: f64 = 0.62;

/// Shortest time on one leg that is a stand (s).
const HELD: f64 = 1.0;

/// Least share of an arm's way that it has gone when the body is lowest.
const THERE: f64 = 0.7;

/// Least angle of a look or a lean (degrees).
const LOOK: f64 = 15.0;
const LEAN: f64 = 8.0;

/// Expected, measured, passed.
type Outcome = (String, String, bool);

/// Action of another limb at the same time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Meanwhile {
    /// Nothing of its own.
    Nothing,
    /// The other hand gestures.
    Gesture,
    /// Anything else.
    Other,
}

/// Checks that the right limb acts.
pub fn limb(tracks: &Tracks, verb: &Verb, side: Option<Side>, meanwhile: Meanwhile) -> Outcome {
    let both = meanwhile != Meanwhile::Nothing;
    let share = |of: &[Vec<Vec3>; 2]| {
        let [left, right] = [0, 1].map(|i| energy(&of[i], tracks.fps));
        (left + right > 1e-9).then(|| left / (left + right))
    };
    let lopsided = |left: Option<f64>, side: Option<Side>, least: f64| {
        let own = match side {
            Some(Side::Right) => left.map(|l| 1.0 - l),
            _ => left,
        };
        let word = side.map_or("", Side::word);
        let got = own.map_or("nothing moves".into(), |s| format!("{:.0} % of the energy", 100.0 * s));
        (format!("{word} with at least {:.0} % of the energy", 100.0 * least), got, own.is_some_and(|s| s >= least))
    };
    match verb.acts {
        // The other hand may go farther, so this one is compared with its own rest.
        Acts::Hand | Acts::Hands if meanwhile == Meanwhile::Gesture => {
            let chosen = match side {
                Some(Side::Left) => 0..1,
                Some(Side::Right) => 1..2,
                _ => 0..2,
            };
            let moved = chosen.map(|hand| excursion(&tracks.hands[hand])).fold(f64::INFINITY, f64::min);
            let least = 0.15 * tracks.leg;
            let word = side.map_or("", Side::word);
            (format!("{word} moves by {least:.2} m"), format!("{moved:.2} m"), moved > least)
        }
        Acts::Hand if both || verb.limb != Limb::Energy => {
            // The other arm swings along with a walk, or keeps its guard: the acting hand goes farther.
            let reach = [0, 1].map(|hand| match (both, verb.limb) {
                (false, Limb::Ahead) => farthest(&tracks.hands[hand], |p| p.x),
                _ => farthest(&tracks.hands[hand], |p| p.z),
            });
            let (own, other) = if side == Some(Side::Left) { (reach[0], reach[1]) } else { (reach[1], reach[0]) };
            let least = 0.05 * tracks.leg;
            let word = side.map_or("", Side::word);
            (format!("{word} farther by {least:.2} m"), format!("{:.2} m", own - other), own - other > least)
        }
        Acts::Hand => lopsided(share(&tracks.hands), side, ACTING),
        Acts::Hands if matches!(side, Some(Side::Left | Side::Right)) => lopsided(share(&tracks.hands), side, ACTING),
        // The leg that stands works as hard as the one that is held up.
        Acts::Foot if verb.shows.contains(&Show::FootHeld) => {
            let (own, other) = match side {
                Some(Side::Left) => (Side::Left, Side::Right),
                _ => (Side::Right, Side::Left),
            };
            let [own_up, other_up] = [own, other].map(|foot| held_up(tracks, Some(foot)));
            let got = format!("{own_up:.1} s, the other {other_up:.1} s");
            (format!("{} up at least twice as long as the other", own.word()), got, own_up > 2.0 * other_up)
        }
        Acts::Foot => {
            let relative = [0, 1].map(|i| tracks.feet[i].clone());
            lopsided(share(&relative), side, ACTING)
        }
        Acts::Hands => {
            let left = share(&tracks.hands);
            let got = left.map_or("nothing moves".into(), |s| format!("{:.0} % by the left", 100.0 * s));
            ("both hands, 25 to 75 % each".into(), got, left.is_some_and(|s| (0.25..=0.75).contains(&s)))
        }
        Acts::Head => {
            let turn = |which: usize| {
                range(&tracks.head.iter().map(|h| h[which]).collect::<Vec<_>>()).map_or(0.0, |(low, high)| high - low)
            };
            let (turned, hands) = (turn(0).max(turn(1)).to_degrees(), hands(tracks));
            let passed = turned > 5.0 && (both || hands < 0.35 * tracks.leg);
            let expected = if both { "the head turns" } else { "the head turns, the hands do not" };
            (expected.into(), format!("{turned:.0} degrees, hands {hands:.2} m"), passed)
        }
        Acts::Body => {
            let steps = swings(tracks, 0).len() + swings(tracks, 1).len();
            ("no step".into(), format!("{steps} steps"), steps == 0)
        }
        Acts::Feet => {
            let steps = swings(tracks, 0).len() + swings(tracks, 1).len();
            (
                "at least two steps".into(),
                format!("{steps} steps"),
                steps >= 2 || verb.synth == Some(Synth::Turn) && steps >= 1,
            )
        }
    }
}

/// Checks that arms which take a pose have taken it when the body is lowest; nothing of arms that repeat something.
pub fn there(tracks: &Tracks, verb: &Verb, side: Option<Side>) -> Option<Outcome> {
    if verb.cycle.is_some() || !matches!(verb.acts, Acts::Hand | Acts::Hands) {
        return None;
    }
    let lowest = (0..tracks.root.len()).min_by(|a, b| tracks.root[*a].z.total_cmp(&tracks.root[*b].z))?;
    let share = |hand: usize| {
        let way: Vec<Vec3> = tracks.hands[hand].iter().zip(&tracks.shoulders[hand]).map(|(p, s)| p - s).collect();
        let most = excursion(&way);
        (most > 1e-6).then(|| (way[lowest] - way[0]).norm() / most)
    };
    let got = match side {
        Some(Side::Left) => share(0)?,
        Some(Side::Right) => share(1)?,
        _ => share(0)?.min(share(1)?),
    };
    let expected = format!("the arms there when the body is lowest: {:.0} % of their way", 100.0 * THERE);
    Some((expected, format!("{:.0} %", 100.0 * got), got >= THERE))
}

/// Returns the largest angle of an arm from hanging down (degrees); of both, of the one that is lifted less.
pub fn lifted(tracks: &Tracks, side: Option<Side>) -> Option<f64> {
    let angle = |(hand, shoulder): (&Vec3, &Vec3)| (hand - shoulder).angle(&-Vec3::z()).to_degrees();
    let most = |arm: usize| tracks.hands[arm].iter().zip(&tracks.shoulders[arm]).map(angle).reduce(f64::max);
    match side {
        Some(Side::Left) => most(0),
        Some(Side::Right) => most(1),
        _ => most(0).zip(most(1)).map(|(a, b)| a.min(b)),
    }
}

/// Returns the greatest value along a path.
fn farthest(path: &[Vec3], of: impl Fn(&Vec3) -> f64) -> f64 {
    path.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
}

fn hands(tracks: &Tracks) -> f64 {
    excursion(&tracks.hands[0]).max(excursion(&tracks.hands[1]))
}

/// Checks what a verb must show.
pub fn shows(tracks: &Tracks, show: Show, side: Option<Side>) -> Outcome {
    let of = |hand: usize| {
        let above = tracks.hands[hand].iter().zip(&tracks.shoulders[hand]).map(|(p, shoulder)| p.z - shoulder.z);
        let above: Vec<f64> = above.collect();
        range(&above).zip(above.first().copied())
    };
    let chosen: Vec<usize> = match side {
        Some(Side::Left) => vec![0],
        Some(Side::Right) => vec![1],
        _ => vec![0, 1],
    };
    let least = |measure: &dyn Fn(usize) -> Option<f64>| {
        chosen.iter().map(|hand| measure(*hand).unwrap_or(f64::NEG_INFINITY)).fold(f64::INFINITY, f64::min)
    };
    match show {
        Show::HandHigh => {
            let up = least(&|hand| of(hand).map(|((_, high), _)| high));
            ("the hand above the shoulder".into(), format!("{up:.2} m"), up > 0.0)
        }
        Show::HandOut => {
            let up = least(&|hand| of(hand).map(|((_, high), first)| high - first));
            (format!("the hand up by {:.2} m", 0.15 * tracks.leg), format!("{up:.2} m"), up > 0.15 * tracks.leg)
        }
        Show::Low => {
            let heights: Vec<f64> = tracks.root.iter().map(|p| p.z).collect();
            let sunk = range(&heights).map_or(0.0, |(low, high)| (high - low) / tracks.leg);
            ("the pelvis down by 12 % of a leg".into(), format!("{:.0} %", 100.0 * sunk), sunk > 0.12)
        }
        Show::FootHeld => {
            let got = held_up(tracks, side);
            (format!("the foot up for {HELD:.0} s at a stretch"), format!("{got:.1} s"), got >= HELD)
        }
        Show::FootHigh => {
            let high = [0, 1].map(|foot| {
                let heights: Vec<f64> = tracks.feet[foot].iter().map(|p| p.z).collect();
                range(&heights).map_or(0.0, |(low, high)| (high - low) / tracks.leg)
            });
            let got = match side {
                Some(Side::Left) => high[0],
                Some(Side::Right) => high[1],
                _ => high[0].max(high[1]),
            };
            ("the foot up by 12 % of a leg".into(), format!("{:.0} %", 100.0 * got), got > 0.12)
        }
        Show::Flight => {
            let all = flights(tracks);
            ("both feet off the ground".into(), format!("{all} times"), all > 0)
        }
        Show::OneLeg => {
            let (own, other) = if side == Some(Side::Left) { (0, 1) } else { (1, 0) };
            let (hops, up) = (swings(tracks, own), swings(tracks, other));
            let alone = hops.iter().filter(|(a, b)| up.iter().any(|(c, d)| c < a && b < d)).count();
            let expected = "the other foot up during every hop".into();
            (expected, format!("{alone} of {}", hops.len()), alone > 0 && alone == hops.len())
        }
        Show::Wide => {
            let apart: Vec<f64> =
                tracks.feet[0].iter().zip(&tracks.feet[1]).map(|(a, b)| ground(&(a - b)).norm()).collect();
            let wider = range(&apart).zip(apart.first()).map_or(0.0, |((_, high), first)| (high - first) / tracks.leg);
            ("the feet apart by 20 % of a leg more".into(), format!("{:.0} %", 100.0 * wider), wider > 0.2)
        }
        Show::Together => {
            let apart = tracks.feet[0].iter().zip(&tracks.feet[1]).map(|(a, b)| ground(&(a - b)).norm());
            let apart: Vec<f64> = apart.collect();
            let share = range(&apart).zip(apart.first()).map_or(1.0, |((low, _), first)| low / first.max(1e-6));
            ("the feet at most 80 % as far apart".into(), format!("{:.0} %", 100.0 * share), share <= 0.8)
        }
        Show::Bent => {
            let angle = bent(tracks);
            ("the trunk forward by 12 degrees".into(), format!("{angle:.0}"), angle > 12.0)
        }
        Show::LookUp | Show::LookDown => {
            let pitch: Vec<f64> = tracks.head.iter().map(|head| head[0]).collect();
            let (low, high) = range(&pitch).unwrap_or((0.0, 0.0));
            let first = pitch.first().copied().unwrap_or(0.0);
            let (word, turned) = if show == Show::LookUp { ("up", first - low) } else { ("down", high - first) };
            let turned = turned.to_degrees();
            (format!("the head {word} by {LOOK:.0} degrees"), format!("{turned:.0}"), turned > LOOK)
        }
    }
}

/// Checks that the acting hand, or both, come to what they touch; nothing where the robot lacks it.
pub fn touches(tracks: &Tracks, touch: Touch, side: Option<Side>) -> Option<Outcome> {
    let gaps = tracks.gaps.get(&touch)?;
    let least = |hand: usize| gaps.iter().map(|gap| gap[hand]).fold(f64::INFINITY, f64::min);
    let gap = match side {
        Some(Side::Left) => least(0),
        Some(Side::Right) => least(1),
        _ => least(0).max(least(1)),
    };
    let most = touch.tolerance() * tracks.leg;
    let expected = format!("the {} touched, within {:.1} cm", touch.words(), 100.0 * most);
    Some((expected, format!("{:.1} cm away", 100.0 * gap), gap <= most))
}

/// Checks where a head looks, or a trunk leans: farther than to the other side.
fn side_or_lean(tracks: &Tracks, verb: &Verb, wanted: Direction) -> Outcome {
    let acts = verb.acts;
    let twists = verb.signal == Some(SignalName::RootYaw);
    let values: Vec<f64> = match (acts, wanted) {
        _ if twists => tracks.yaw.clone(),
        (Acts::Head, _) => tracks.head.iter().map(|head| head[1]).collect(),
        (_, Direction::Left | Direction::Right) => tracks.lean.clone(),
        _ => tracks.pitch.clone(),
    };
    let first = values.first().copied().unwrap_or(0.0);
    let (low, high) = range(&values).map_or((0.0, 0.0), |(low, high)| (low - first, high - first));
    let is_low = matches!(wanted, Direction::Right | Direction::Backward);
    let (own, other) = if is_low { (-low, high) } else { (high, -low) };
    let (own, other) = (own.to_degrees(), other.to_degrees());
    let least = if acts == Acts::Head { LOOK } else { LEAN };
    let what = match acts {
        Acts::Head => "a look",
        _ if twists => "a twist",
        _ => "a lean",
    };
    let (what, to) = (what, format!("{wanted:?}").to_lowercase());
    let got = format!("{own:.0} degrees, {other:.0} the other way");
    (format!("{what} {to} by {least:.0} degrees"), got, own > least && own > 2.0 * other)
}

/// Checks the way: the root's displacement in the heading of the first frame, or the sense of a turn.
pub fn direction(tracks: &Tracks, verb: &Verb, wanted: Direction) -> Outcome {
    let (Some(first), Some(last), Some(from), Some(to)) =
        (tracks.root.first(), tracks.root.last(), tracks.yaw.first(), tracks.yaw.last())
    else {
        return (String::new(), "no frame".into(), false);
    };
    if matches!(verb.synth, Some(Synth::Turn | Synth::Curve)) {
        let turned = (to - from).to_degrees();
        let passed = if wanted == Direction::Left { turned > 20.0 } else { turned < -20.0 };
        return (
            format!("a turn to the {wanted:?}").to_lowercase(),
            format!("{turned:+.0} degrees to the left"),
            passed,
        );
    }
    if matches!(verb.acts, Acts::Head | Acts::Body) {
        return side_or_lean(tracks, verb, wanted);
    }
    let way = ground(&(last - first));
    let (sin, cos) = from.sin_cos();
    let (ahead, left) = (cos * way.x + sin * way.y, cos * way.y - sin * way.x);
    let far = 0.2 * tracks.leg;
    let passed = match wanted {
        Direction::Left | Direction::Right if verb.synth == Some(Synth::Diagonal) => {
            let aside = if wanted == Direction::Left { left } else { -left };
            ahead > 0.5 * far && (aside / ahead - 1.0).abs() < 0.6
        }
        Direction::Forward => ahead > far && ahead > left.abs(),
        Direction::Backward => ahead < -far && -ahead > left.abs(),
        Direction::Left => left > far && left > ahead.abs(),
        Direction::Right => left < -far && -left > ahead.abs(),
        Direction::InPlace => way.norm() < far,
    };
    (format!("{wanted:?}").to_lowercase(), format!("{ahead:+.2} m ahead, {left:+.2} m to the left"), passed)
}
