//! One sentence's content, drawn by its address.

use lifelike_checkpoint::rng::stream;
use rand::Rng;
use rand::seq::IndexedRandom;

use super::table::{Acts, Grammar, Synth, Tempo, Verb};
use crate::dataset::Split;
use crate::facts::{Action, Direction, Facts, HeldOut, Mood, Relation, Side, Size, Speed};
use crate::posture::{Posture, Turn};

/// Share of the combinations that are never trained on.
const HELD_OUT: f64 = 0.08;
/// Share of the other clips whose captions are in held-out words.
const NEW_WORDS: f64 = 0.03;
/// Shares of the rest for validation and test.
const VALIDATION: f64 = 0.04;
const TEST: f64 = 0.06;
/// Angles of turns (degrees).
const ANGLES: [u32; 6] = [45, 60, 90, 120, 135, 180];

/// One action as it is to be made.
#[derive(Debug, Clone, PartialEq)]
pub struct PartDraw {
    /// The verb's number in the grammar.
    pub verb: usize,
    /// Flag: the mirror image of the clip as written.
    pub mirrored: bool,
    /// Cycles, pairs of steps to the side; 0 where there are none.
    pub cycles: u32,
    /// Angle of a turn or arc (degrees); 0 where there is none.
    pub degrees: f64,
    /// Times as fast as written.
    pub speed: f64,
    /// Times as large as written.
    pub gain: f64,
    /// The action as a sentence has it.
    pub action: Action,
    /// Bearing of trunk, head and knees during it.
    pub carriage: Carriage,
}

/// Bearing during an action, beside what the action does itself.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Carriage {
    /// Rotation of the trunk.
    pub trunk: Turn,
    /// Rotation of the head.
    pub head: Turn,
    /// Depth to which bent knees lower the pelvis (m, of the keyframed figure).
    pub sink: f64,
}

impl Carriage {
    /// Returns the bearing that a posture describes; its arms and feet are none.
    pub fn of(posture: &Posture) -> Self {
        Self {
            trunk: posture.trunk.unwrap_or_default(),
            head: posture.head.unwrap_or_default(),
            sink: posture.sink.unwrap_or(0.0),
        }
    }
}

/// One clip as it is to be made.
#[derive(Debug, Clone, PartialEq)]
pub struct Draw {
    /// The address.
    pub index: u64,
    /// The split.
    pub split: Split,
    /// One action, or two.
    pub parts: Vec<PartDraw>,
    /// Facts that will be said.
    pub facts: Facts,
}

/// Draws the content of clip `index` of the grammar: always the same for the same seed and index.
pub fn draw(grammar: &Grammar, usable: &[usize], seed: u64, index: u64) -> Option<Draw> {
    let mut rng = stream(seed, "grammar", index, 0);
    let of = |wanted: &dyn Fn(&Verb) -> bool| -> Vec<usize> {
        usable.iter().copied().filter(|v| wanted(&grammar.verbs[*v])).collect()
    };
    let relation = match rng.random_range(0..100) {
        0..60 => Relation::Single,
        60..80 => Relation::Then,
        _ => Relation::While,
    };
    let chosen: Vec<usize> = match relation {
        Relation::Single => vec![*usable.choose(&mut rng)?],
        Relation::Then => {
            let first = *usable.choose(&mut rng)?;
            vec![first, *of(&|verb| verb.name != grammar.verbs[first].name).choose(&mut rng)?]
        }
        Relation::While => vec![*of(&|verb| verb.arms).choose(&mut rng)?, *of(&|verb| verb.carries).choose(&mut rng)?],
    };
    let parts: Vec<PartDraw> = chosen.iter().map(|v| part(grammar, *v, relation, &mut rng)).collect();
    let actions: Vec<Action> = parts.iter().map(|part| part.action.clone()).collect();
    let (split, held_out) = split(&actions, relation, &mut rng);
    Some(Draw { index, split, parts, facts: Facts { relation, actions, held_out } })
}

/// Draws one action.
fn part<R: Rng>(grammar: &Grammar, number: usize, relation: Relation, rng: &mut R) -> PartDraw {
    let verb = &grammar.verbs[number];
    let single = relation == Relation::Single;
    let mirrored = verb.has_sides() && rng.random_bool(0.5);
    let mut action = Action { side: verb.side, direction: verb.direction, ..Action::of(&verb.name) };
    if mirrored {
        action = action.mirrored();
    }
    let [fewest, most] = verb.cycles.unwrap_or([0, 0]);
    // Two actions have less time each.
    let most = if single { most } else { most.min(fewest.max(2)) };
    let mut cycles = rng.random_range(fewest..=most);
    if relation == Relation::While && verb.carries {
        // Legs walk as long as arms need.
        cycles = most.max(verb.cycles.map_or(0, |[_, most]| most));
    }
    let counted = verb.count.map(|count| count.per_cycle * cycles + count.extra);
    let legs_of_two = relation == Relation::While && verb.acts == Acts::Feet;
    action.count = counted.filter(|_| !legs_of_two && rng.random_bool(0.7));
    let mut degrees = 0.0;
    match verb.synth {
        Some(Synth::Turn) => {
            let angle = ANGLES.choose(rng).copied().unwrap_or(90);
            degrees = f64::from(angle);
            action.degrees = Some(angle).filter(|_| rng.random_bool(0.7));
        }
        Some(Synth::Curve) => degrees = rng.random_range(50.0..110.0),
        _ => {}
    }
    // One class is said at a time, of two actions rarely.
    let jitter = |rng: &mut R| rng.random_range(0.95..1.06);
    let (mut speed, mut gain) = (jitter(rng), jitter(rng));
    let said = if single { rng.random_range(0..10) } else { rng.random_range(0..25) };
    let repeats = verb.tempo != Tempo::Period || counted.is_some_and(|n| n > 1);
    match said {
        0..3 if verb.speeds && repeats && (single || verb.tempo != Tempo::Duration) => {
            let slow = rng.random_bool(0.5);
            speed = if slow { rng.random_range(0.6..0.76) } else { rng.random_range(1.35..1.55) };
            action.speed = Some(if slow { Speed::Slow } else { Speed::Fast });
        }
        3..5 if verb.sizes => {
            let small = rng.random_bool(0.5);
            gain = if small { rng.random_range(0.5..0.72) } else { rng.random_range(1.32..1.48) };
            action.size = Some(if small { Size::Small } else { Size::Big });
        }
        5..7 if verb.moods && relation == Relation::Single => {
            action.mood = Some(if rng.random_bool(0.5) { Mood::Sad } else { Mood::Proud });
        }
        _ => {}
    }
    PartDraw { verb: number, mirrored, cycles, degrees, speed, gain, action, carriage: Carriage::default() }
}

/// Returns the split of a combination: by what is said, not by the seed, so that no seed trains on what another holds
/// out.
fn split<R: Rng>(actions: &[Action], relation: Relation, rng: &mut R) -> (Split, Option<HeldOut>) {
    let says_more = |a: &Action| {
        let qualities = [a.speed.is_some(), a.size.is_some(), a.mood.is_some(), a.count.is_some(), a.degrees.is_some()];
        let sided = matches!(a.side, Some(Side::Left | Side::Right))
            || matches!(a.direction, Some(Direction::Left | Direction::Right));
        qualities.iter().filter(|q| **q).count() + usize::from(sided) > 1
    };
    let key: String = match actions {
        [a] if says_more(a) => a.key(),
        // Of two actions, which verbs meet.
        [a, b] => format!("{relation:?} {} {}", a.verb, b.verb),
        _ => String::new(),
    };
    if !key.is_empty() && stream(0, &key, 0, 0).random_bool(HELD_OUT) {
        return (Split::HeldOut, Some(HeldOut::Combination));
    }
    let at: f64 = rng.random();
    if at < NEW_WORDS {
        (Split::HeldOut, Some(HeldOut::Words))
    } else if at < NEW_WORDS + VALIDATION {
        (Split::Validation, None)
    } else if at < NEW_WORDS + VALIDATION + TEST {
        (Split::Test, None)
    } else {
        (Split::Train, None)
    }
}
