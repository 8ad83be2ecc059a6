//! Sides in turn, counts of each, turns between two ways, and a pace as a way in a time.

use super::reader::{LIMBS_AND_UNITS, Piece, Reader, name};
use super::said::{Said, said};
use super::split::Join;
use super::{Clause, Script};
use crate::facts::{Action, Direction, Side};
use crate::grammar::{Acts, Show, Synth, Tempo, Verb};

/// Time of both sides, once each, where a time is filled with them (s).
const TURN: f64 = 6.0;
/// Most actions of sides in turn.
const MOST_TURNS: u32 = 24;
/// Duration of a walk of which only the pace is said, and its longest way (s, m).
const PACED: [f64; 2] = [5.0, 4.0];
/// Fastest pace (m/s) and longest way (m) that a motion here has.
const FASTEST: f64 = 3.0;
const FARTHEST: f64 = 30.0;
/// Words for where steps go.
const GOING: [&str; 9] = ["left", "right", "forward", "forwards", "ahead", "back", "backward", "backwards", "sideways"];
/// Highest and longest jump (m).
const HIGHEST: f64 = 0.3;

impl Reader<'_> {
    /// Returns the walk ahead for "walk back" after somebody has turned around.
    pub(super) fn on_the_way_back<'v>(&'v self, verb: &'v Verb, words: &[String], script: &Script) -> &'v Verb {
        let says = |all: &[&str]| words.iter().any(|word| all.contains(&word.as_str()));
        let last = script.clauses.last().and_then(|clause| clause.actions.last());
        let has_turned = last.is_some_and(|last| self.is_turn(last) && last.degrees == Some(180));
        let ahead = match verb.name.as_str() {
            "walk_backward" => "walk",
            "step_back" => "step_forward",
            _ => return verb,
        };
        let is_return = says(&["back"]) && !says(&["backward", "backwards"]);
        if has_turned && is_return { self.grammar.verb(ahead).unwrap_or(verb) } else { verb }
    }

    /// Returns whether a gait needs a turn before it: "walk away", "tiptoe forward and run back".
    pub(super) fn runs_back(&self, verb: &Verb, words: &[String], script: &Script) -> bool {
        let says = |all: &[&str]| words.iter().any(|word| all.contains(&word.as_str()));
        let last = script.clauses.iter().rev().flat_map(|clause| &clause.actions).find(|action| action.verb != "stand");
        let has_gone = last.is_some_and(|last| last.direction == Some(Direction::Forward));
        let goes = verb.acts == Acts::Feet && verb.direction == Some(Direction::Forward);
        if goes && says(&["away"]) && !last.is_some_and(|last| self.is_turn(last)) {
            return true;
        }
        goes && has_gone && says(&["back"]) && !says(&["backward", "backwards", "forward", "bend"])
    }

    /// Returns the verb that looks to both sides where both were named.
    pub(super) fn both_ways<'v>(&'v self, verb: &'v Verb, said: &Said) -> &'v Verb {
        let both = match verb.name.as_str() {
            "look_aside" if said.side == Some(Side::Both) => "look_around",
            "twist_aside" if said.side == Some(Side::Both) && said.degrees.is_none() => "twist",
            "walk_sideways" if said.alternates => "step_touch",
            "one_arm_out" if said.side == Some(Side::Both) => "arms_to_sides",
            "hand_on_hip" if said.side == Some(Side::Both) => "hands_on_hips",
            "reach_up" if said.side == Some(Side::Both) => "raise_arms",
            _ => return verb,
        };
        self.grammar.verb(both).unwrap_or(verb)
    }

    /// Returns words in which a verb that is said again and again is counted: "clap clap clap" is three times.
    pub(super) fn counted_words(&self, words: Vec<String>) -> Vec<String> {
        let mut out: Vec<String> = Vec::with_capacity(words.len());
        let mut was_counted = false;
        for same in words.chunk_by(|a, b| a == b) {
            let is_verb = same[0] == "step" || self.phrases.is_main_verb(&same[0]);
            let is_counted = same.len() > 1 && is_verb;
            // "Step step clap": two, then another.
            let follows =
                was_counted && is_verb || is_counted && out.last().is_some_and(|last| self.phrases.is_main_verb(last));
            out.extend(follows.then(|| ",".to_string()));
            was_counted = is_counted;
            out.extend(if is_counted {
                // Steps that go nowhere are on the spot.
                let place = same[0] == "step" && words.iter().all(|word| !GOING.contains(&word.as_str()));
                let place = place.then(|| ["in", "place"].map(String::from)).into_iter().flatten();
                [same[0].clone()].into_iter().chain(place).chain([same.len().to_string(), "times".into()]).collect()
            } else {
                same.to_vec()
            });
        }
        out
    }

    /// Adds an action of one side and then of the other: "left and right" all of one side first, "alternating" one by one.
    pub(super) fn in_turn(&self, script: &mut Script, verb: &Verb, said: &Said) {
        let first = said.first.unwrap_or(Side::Left);
        let sides = [first, first.mirrored()];
        let turns = match said.count.filter(|_| said.alternates) {
            Some(n) if said.of_each => 2 * n,
            Some(n) => n,
            // Each for a moment, until the time is over.
            None if said.alternates => said.seconds.map_or(2, |seconds| 2 * (seconds / TURN).round().max(1.0) as u32),
            None => 2,
        };
        let seconds = said.seconds.map(|seconds| if said.alternates { seconds / f64::from(turns) } else { seconds });
        if turns > MOST_TURNS {
            script.notes.push(format!("'{}' is done {MOST_TURNS} times, not {turns}", name(verb)));
        }
        for turn in 0..turns.min(MOST_TURNS) {
            let side = sides[turn as usize % 2];
            let count = if said.alternates && turns > 2 { Some(1) } else { said.count };
            let of_hand = [Some(side), None, None];
            let one = Said { side: Some(side), sides: of_hand, count, in_turn: false, ..said.clone() };
            let (action, times) = self.action(verb, &one, &mut script.notes);
            self.add(script, Join::Then, action, seconds, times, [false; 2]);
        }
    }

    /// Returns whether words without a verb count a side where a piece counts another one.
    pub(super) fn counts_apart(&self, last: &Piece, words: &[String]) -> bool {
        let [one, other] = [said(&last.words), said(words)];
        let is_limb = |word: &String| LIMBS_AND_UNITS.contains(&self.phrases.base(word).as_str());
        let explains = |word: &String| other.used.contains(word) || self.phrases.filler.contains(word) || is_limb(word);
        last.fit.is_some()
            && one.count.is_some()
            && other.count.is_some()
            && one.side.is_some()
            && one.side != other.side
            && words.iter().all(explains)
    }

    /// Returns whether an action is a turn on the spot.
    pub(super) fn is_turn(&self, action: &Action) -> bool {
        self.grammar.verb(&action.verb).is_ok_and(|verb| verb.synth == Some(Synth::Turn))
    }

    /// Returns whether of two actions one is a turn and the other a gait of no length that was said.
    pub(super) fn turns_between(&self, last: &Clause, action: &Action, seconds: Option<f64>) -> bool {
        let [before] = last.actions.as_slice() else { return false };
        let gait = if self.is_turn(action) { before } else { action };
        let goes = |verb: &Verb| verb.acts == Acts::Feet && verb.cycle.is_some() && verb.tempo == Tempo::Pace;
        let is_free = gait.count.is_none() && gait.metres.is_none();
        let is_plain = last.seconds.is_none() && seconds.is_none() && last.times == 1;
        self.is_turn(action) != self.is_turn(before)
            && is_free
            && is_plain
            && self.grammar.verb(&gait.verb).is_ok_and(goes)
    }
}

/// Returns the reason why a pace or a way is impossible, where it is.
pub(super) fn beyond(verb: &Verb, said: &Said) -> Option<String> {
    let pace = said.pace.filter(|pace| *pace > FASTEST && verb.acts == Acts::Feet);
    if let Some(pace) = pace {
        return Some(format!("{pace:.1} m/s is faster than its legs go (at most {FASTEST} m/s)"));
    }
    let leaps = verb.shows.contains(&Show::Flight) && verb.tempo != Tempo::Pace;
    let jumps = leaps.then_some(said.metres).flatten();
    if let Some(metres) = jumps.filter(|metres| *metres > HIGHEST) {
        return Some(format!("{metres} m is more than it jumps: its feet rise by centimetres"));
    }
    let far = said.metres.filter(|metres| *metres > FARTHEST && verb.acts == Acts::Feet)?;
    Some(format!("{far} m is farther than a motion here goes (at most {FARTHEST} m)"))
}

/// Returns what is said with a pace as a way in a time: 0.4 m/s for 5 s are 2 m.
pub(super) fn paced(mut said: Said, notes: &mut Vec<String>) -> Said {
    let Some(pace) = said.pace.filter(|pace| *pace > 0.0) else { return said };
    let seconds = match (said.metres, said.seconds) {
        (Some(metres), _) => metres / pace,
        (None, Some(seconds)) => seconds,
        (None, None) => PACED[0].min(PACED[1] / pace),
    };
    let rounded = |value: f64| (100.0 * value).round() / 100.0;
    let metres = rounded(said.metres.unwrap_or(pace * seconds));
    (said.metres, said.seconds) = (Some(metres), Some(rounded(seconds)));
    notes.push(format!("{pace} m/s is {metres} m in {} s", rounded(seconds)));
    said
}

/// Gives a gait the steps or metres of the way before, where it is the same way or leads back: "walk back to where you
/// started".
pub(super) fn gone_before(script: &Script, said: &Said, words: &[String], mut action: Action) -> Action {
    let leads_back = words.iter().any(|word| ["started", "began", "start", "came"].contains(&word.as_str()));
    let mut ways = script.clauses.iter().rev().filter_map(|clause| clause.actions.last());
    let gone = match (said.same, leads_back) {
        (true, _) => ways.next(),
        (false, true) => ways.find(|way| way.direction == Some(Direction::Forward)),
        (false, false) => None,
    };
    let Some(gone) = gone else { return action };
    let is_counted = gone.verb == action.verb || leads_back;
    action.count = action.count.or(gone.count.filter(|_| is_counted));
    action.metres = action.metres.or(gone.metres);
    action
}

/// Takes the action of the clause before the last one where it is said again as what goes on meanwhile: "turn slowly and
/// wave as you turn" is one clause.
pub(super) fn said_before(script: &mut Script, action: Action) -> Action {
    let [.., earlier, last] = &script.clauses[..] else { return action };
    let ([same], [other]) = (&earlier.actions[..], &last.actions[..]) else { return action };
    let is_same = same.verb == action.verb && other.verb != action.verb;
    let is_plain = (action.count.is_none() || action.count == same.count)
        && (action.degrees.is_none() || action.degrees == same.degrees)
        && action.metres.is_none();
    if !is_same || !is_plain {
        return action;
    }
    script.clauses.remove(script.clauses.len() - 2).actions.remove(0)
}
