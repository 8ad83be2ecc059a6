//! Exact checks: does a motion what a sentence promised?
//!
//! [`Tracks`] are the paths of a clip by forward kinematics; [`check`] compares each fact with what is
//! [measured](measure) on them. Nothing is learned, so a generator can be judged by it.

mod acting;
pub mod measure;
mod tracks;

use serde::Serialize;

pub use tracks::{KEYFRAMED, SIMULATED, SignalName, Tracks};

use crate::error::LanguageError;
use crate::facts::{Action, Facts, Mood, Relation, Size, Speed};
use crate::grammar::{Acts, Grammar, Show, Synth, Tempo, Verb};
use acting::Meanwhile;

/// Tempo and amplitude that one sees: at most this share of the normal ones, and at least this.
const LESS: f64 = 0.8;
const MORE: f64 = 1.25;
/// The same of long steps, which legs end.
const LONGER: f64 = 1.12;
/// Largest error of a distance, as a share.
const DISTANCE: f64 = 0.15;

/// Kind of a fact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fact {
    /// The right limb acts.
    Limb,
    /// The verb's features are seen.
    Shape,
    /// The hand touches what it is said to touch.
    Touch,
    /// The number of repetitions or steps.
    Count,
    /// The way over the ground, or the sense of a turn.
    Direction,
    /// The angle of a turn.
    Degrees,
    /// The length of the way over the ground.
    Distance,
    /// The class of speed.
    Speed,
    /// The class of amplitude.
    Size,
    /// The posture of a mood.
    Mood,
    /// The duration, where one was asked for.
    Seconds,
}

impl Fact {
    /// Every kind.
    pub const ALL: [Self; 11] = [
        Self::Limb,
        Self::Shape,
        Self::Touch,
        Self::Count,
        Self::Direction,
        Self::Degrees,
        Self::Distance,
        Self::Speed,
        Self::Size,
        Self::Mood,
        Self::Seconds,
    ];

    /// Returns the name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Limb => "limb",
            Self::Shape => "shape",
            Self::Touch => "touch",
            Self::Count => "count",
            Self::Direction => "direction",
            Self::Degrees => "degrees",
            Self::Distance => "distance",
            Self::Speed => "speed",
            Self::Size => "size",
            Self::Mood => "mood",
            Self::Seconds => "seconds",
        }
    }
}

/// Least angle from hanging down of an arm that is held out, where no other was said (degrees).
const LEVEL: f64 = 80.0;
/// Error of an arm's angle (degrees).
const LIFT: f64 = 15.0;

/// Result of one check.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// The verb.
    pub verb: String,
    /// The fact.
    pub fact: Fact,
    /// Promised value.
    pub expected: String,
    /// Measured value.
    pub got: String,
    /// Flag of agreement.
    pub passed: bool,
}

/// Checks every fact on the paths of a clip. Of two actions one after the other, the clip is divided where most hold.
///
/// # Errors
/// [`LanguageError::Grammar`] for a verb that the grammar has not.
pub fn check(tracks: &Tracks, grammar: &Grammar, facts: &Facts) -> Result<Vec<Finding>, LanguageError> {
    let verbs = facts.actions.iter().map(|action| grammar.verb(&action.verb)).collect::<Result<Vec<_>, _>>()?;
    match (facts.relation, facts.actions.as_slice(), verbs.as_slice()) {
        (Relation::Then, [a, b], [first, second]) => {
            let step = (tracks.fps / 10.0).ceil().max(1.0) as usize;
            let least = tracks.fps.ceil() as usize;
            let mut best: Vec<Finding> = Vec::new();
            let mut most = None;
            for at in (least..tracks.len().saturating_sub(least)).step_by(step) {
                let mut found = of_action(&tracks.part(0..at), first, a, Meanwhile::Nothing);
                found.extend(of_action(&tracks.part(at..tracks.len()), second, b, Meanwhile::Nothing));
                let passed = found.iter().filter(|f| f.passed).count();
                if most.is_none_or(|most| passed > most) {
                    most = Some(passed);
                    best = found;
                }
                if most == Some(best.len()) {
                    break;
                }
            }
            Ok(best)
        }
        (relation, actions, verbs) => {
            let gestures = verbs.iter().filter(|verb| matches!(verb.acts, Acts::Hand | Acts::Hands)).count();
            let meanwhile = match relation == Relation::While {
                true if gestures > 1 => Meanwhile::Gesture,
                true => Meanwhile::Other,
                false => Meanwhile::Nothing,
            };
            let each = actions.iter().zip(verbs);
            let mut found: Vec<Finding> =
                each.flat_map(|(action, verb)| of_action(tracks, verb, action, meanwhile)).collect();
            // A gesture on a trunk that bends or jumps has its head elsewhere than alone.
            if meanwhile != Meanwhile::Nothing && verbs.iter().any(|verb| verb.bends || verb.jumps()) {
                found.retain(|finding| finding.fact != Fact::Mood);
            }
            if let ([above, _], [upper, lower]) = (actions, verbs)
                && meanwhile != Meanwhile::Nothing
                && lower.shows.contains(&Show::Low)
            {
                found.extend(acting::there(tracks, upper, above.side).map(|(expected, got, passed)| Finding {
                    verb: upper.name.clone(),
                    fact: Fact::Shape,
                    expected,
                    got,
                    passed,
                }));
            }
            Ok(found)
        }
    }
}

/// Returns the findings of one action.
fn of_action(tracks: &Tracks, verb: &Verb, action: &Action, meanwhile: Meanwhile) -> Vec<Finding> {
    let mut found = Vec::new();
    let mut add = |fact: Fact, expected: String, got: String, passed: bool| {
        found.push(Finding { verb: verb.name.clone(), fact, expected, got, passed });
    };
    let side = action.side;
    let (expected, got, passed) = acting::limb(tracks, verb, side, meanwhile);
    add(Fact::Limb, expected, got, passed);
    let lifts = action.degrees.filter(|_| verb.angles);
    for show in verb.shows.iter().filter(|_| lifts.is_none()) {
        let (expected, got, passed) = acting::shows(tracks, *show, side);
        add(Fact::Shape, expected, got, passed);
    }
    // An arm that is held out is level.
    if let Some(got) = acting::lifted(tracks, side).filter(|_| verb.angles && lifts.is_none()) {
        add(Fact::Shape, format!("the arm up by {LEVEL:.0} degrees"), format!("{got:.0}"), got >= LEVEL);
    }
    if let Some((expected, got, passed)) =
        verb.touches.and_then(|touch| acting::touches(tracks, touch, side.or(verb.side)))
    {
        add(Fact::Touch, expected, got, passed);
    }
    if let (Some(wanted), Some(rule)) = (action.count, verb.count) {
        let got = measure::count(tracks, &rule, side);
        let text = got.map_or("nothing that can be counted".into(), |n| n.to_string());
        add(Fact::Count, wanted.to_string(), text, got == Some(wanted as usize));
    }
    if let Some(direction) = action.direction {
        let (expected, got, passed) = acting::direction(tracks, verb, direction);
        add(Fact::Direction, expected, got, passed);
    }
    if let (Some(degrees), Some(got)) = (lifts, acting::lifted(tracks, side)) {
        let passed = (got - f64::from(degrees)).abs() <= LIFT;
        add(Fact::Degrees, format!("{degrees} +- {LIFT}"), format!("{got:.0}"), passed);
    }
    if let Some(degrees) = action.degrees.filter(|_| verb.bends) {
        let got = measure::bent(tracks);
        add(
            Fact::Degrees,
            format!("{degrees} +- {LIFT}"),
            format!("{got:.0}"),
            (got - f64::from(degrees)).abs() <= LIFT,
        );
    }
    let turned = action.degrees.filter(|_| !verb.angles && !verb.bends);
    if let (Some(degrees), Some(first), Some(last)) = (turned, tracks.yaw.first(), tracks.yaw.last()) {
        let got = (last - first).to_degrees().abs();
        add(Fact::Degrees, format!("{degrees} +- 20"), format!("{got:.0}"), (got - f64::from(degrees)).abs() <= 20.0);
    }
    if let Some(metres) = action.metres {
        let is_arc = verb.synth == Some(Synth::Curve);
        let got = if is_arc { measure::wide(tracks) } else { measure::way(tracks) };
        let passed = (got / metres - 1.0).abs() <= DISTANCE;
        add(Fact::Distance, format!("{metres} m, within {:.0}%", 100.0 * DISTANCE), format!("{got:.2} m"), passed);
    }
    let Some(nominal) = action.nominal else { return found };
    // What is done once has no period.
    let period = measure::tempo(tracks, verb, side);
    if let Some(speed) = action.speed.filter(|_| action.count != Some(1) || period.is_some()) {
        // Times as fast as normal: of what lasts, the inverse.
        let ratio = period.map(|tempo| match verb.tempo {
            Tempo::Pace => tempo / nominal.tempo,
            Tempo::Period | Tempo::Duration => nominal.tempo / tempo,
        });
        let (expected, passed) = match speed {
            Speed::Slow => (format!("at most {LESS} times as fast"), ratio.is_some_and(|r| r <= LESS)),
            Speed::Fast => (format!("at least {MORE} times as fast"), ratio.is_some_and(|r| r >= MORE)),
        };
        add(Fact::Speed, expected, ratio.map_or("no tempo".into(), |r| format!("{r:.2}")), passed);
    }
    if let Some(size) = action.size {
        let ratio = measure::amplitude(tracks, verb, side).map(|a| a / nominal.amplitude);
        let most = if verb.acts == Acts::Feet { LONGER } else { MORE };
        let (expected, passed) = match size {
            Size::Small => (format!("at most {LESS} times as large"), ratio.is_some_and(|r| r <= LESS)),
            Size::Big => (format!("at least {most} times as large"), ratio.is_some_and(|r| r >= most)),
        };
        add(Fact::Size, expected, ratio.map_or("no amplitude".into(), |r| format!("{r:.2}")), passed);
    }
    // Of a bend to an angle that was said the usual bearing says nothing.
    let is_bent = verb.bends && action.degrees.is_some();
    if let Some(mood) = action.mood.filter(|_| !is_bent) {
        let change = (measure::head_pitch(tracks) - nominal.head_pitch).to_degrees();
        // A chest bends half as far as a head does.
        let (what, share) = if tracks.head.is_empty() { ("chest", 0.5) } else { ("head", 1.0) };
        let (way, least) = match mood {
            Mood::Sad | Mood::Tired | Mood::Frail => ("down", 6.0 * share),
            Mood::Angry | Mood::Afraid => ("down", 4.0 * share),
            Mood::Proud | Mood::Happy | Mood::Graceful => ("up", 3.0 * share),
        };
        let passed = if way == "down" { change >= least } else { change <= -least };
        let expected = format!("the {what} at least {least} degrees further {way}");
        add(Fact::Mood, expected, format!("{change:+.1}"), passed);
    }
    found
}
