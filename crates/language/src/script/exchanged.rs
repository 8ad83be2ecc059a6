//! Verbs in the place of others: by number, by hand, by way.

use super::reader::{Reader, name};
use super::said::Said;
use crate::checks::SignalName;
use crate::facts::{Direction, Speed};
use crate::grammar::{Acts, Verb};

impl Reader<'_> {
    /// Returns the verb that fits what was said: steps one by one for an odd number, a foot that stays up for a
    /// duration.
    pub(super) fn counted_by_one<'v>(&'v self, verb: &'v Verb, said: &Said) -> &'v Verb {
        if verb.name == "knee_raise" && (said.seconds.is_some() || said.holds) && said.count.is_none() {
            return self.grammar.verb("balance").unwrap_or(verb);
        }
        let is_pair = verb.count.is_some_and(|rule| rule.signal == SignalName::Steps && rule.per_cycle == 2);
        let odd = said.count.is_some_and(|n| !n.is_multiple_of(2));
        let other = match verb.name.as_str() {
            "walk" => "step_forward",
            "walk_backward" => "step_back",
            "small_steps" | "big_steps" => "step_forward",
            _ => return self.of_one_hand(verb, said),
        };
        if is_pair && odd { self.grammar.verb(other).unwrap_or(verb) } else { verb }
    }

    /// Returns the verb of one hand where one was named, of a verb of both that has such a one.
    fn of_one_hand<'v>(&'v self, verb: &'v Verb, said: &Said) -> &'v Verb {
        let one = match verb.name.as_str() {
            "arms_to_sides" => "one_arm_out",
            "hands_on_hips" => "hand_on_hip",
            "raise_arms" => "reach_up",
            "wave_both" => "wave",
            "arms_ahead" => "point_ahead",
            "heart_arms" => "hand_on_heart",
            _ => return verb,
        };
        if said.names_one_hand() { self.grammar.verb(one).unwrap_or(verb) } else { verb }
    }

    /// Returns the gait that goes the way that was said, where a verb goes ahead: "run backwards" is walking backward.
    /// A verb that has no other keeps its way, and that is said.
    pub(super) fn facing<'v>(
        &'v self,
        verb: &'v Verb,
        words: &[String],
        mut said: Said,
        notes: &mut Vec<String>,
    ) -> (&'v Verb, Said) {
        let has = |all: &[&str]| words.iter().any(|word| all.contains(&word.as_str()));
        let is_aside = matches!(said.direction, Some(Direction::Left | Direction::Right)) || has(&["sideways"]);
        let is_back = has(&["backward", "backwards"]);
        let is_ahead = has(&["forward", "forwards", "ahead", "straight"]);
        let goes_ahead = verb.acts == Acts::Feet && verb.direction == Some(Direction::Forward) && verb.synth.is_none();
        if !goes_ahead || is_ahead || !(is_aside || is_back) {
            if goes_ahead && is_ahead && is_back {
                notes.push(format!("'{}' cannot go forward and backward: it goes forward", name(verb)));
            }
            return (verb, said);
        }
        let way = if is_back { "backward" } else { "to the side" };
        let other = match (verb.name.as_str(), is_back) {
            ("jump_forward", true) => "jump_backward",
            ("jump_forward", false) => "jump_sideways",
            ("step_forward", true) => "step_back",
            (
                "walk" | "run" | "jog_forward" | "small_steps" | "big_steps" | "sneak" | "walk_tired" | "march_forward",
                true,
            ) => "walk_backward",
            ("walk" | "run" | "jog_forward" | "small_steps" | "big_steps" | "step_forward" | "sneak", false) => {
                "walk_sideways"
            }
            _ => {
                notes.push(format!("'{}' goes forward, not {way}", name(verb)));
                return (verb, said);
            }
        };
        let Ok(found) = self.grammar.verb(other) else { return (verb, said) };
        if !["walk", "jump_forward", "step_forward"].contains(&verb.name.as_str()) {
            notes.push(format!("'{}' {way} is done as '{}'", name(verb), name(found)));
        }
        said.speed = said.speed.or(match verb.name.as_str() {
            "run" | "jog_forward" => Some(Speed::Fast),
            "sneak" | "walk_tired" => Some(Speed::Slow),
            _ => None,
        });
        (found, said)
    }
}
