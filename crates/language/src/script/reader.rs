//! From a sentence to a script.

use std::collections::BTreeSet;

use super::beside::{HOLDS, held_together, is_goal, is_hold, of_hand, of_the_other, without_negations};
use super::learned::Learned;
use super::limbs::{back_again, of_supporting_leg};
use super::phrases::{Fit, Meaning, Phrases};
use super::said::{Said, said};
use super::situations::Situations;
use super::spelling::spelt;
use super::split::{Join, is_participle, normal, pieces};
use super::turns::{beyond, gone_before, paced, said_before};
use super::{Clause, Impossible, Script};
use crate::error::LanguageError;
use crate::facts::{Action, Direction, Side, Size};
use crate::grammar::{Acts, Grammar, Synth, Verb};

/// Least number that is an angle where a turn has one.
const LEAST_ANGLE: u32 = 20;
/// Angles by which a trunk bends (degrees).
const LEAST_BENT: u32 = 5;
const MOST_BENT: u32 = 60;
/// Angle of a low bow (degrees).
const LOW_BOW: u32 = 55;
/// Duration of a pose that is held for no time that was said (s).
const HOLD: f64 = 3.0;
/// Duration of what is done "for a bit" (s).
const BRIEF: f64 = 5.0;
/// Largest angle of a lifted arm (degrees).
const MOST_LIFTED: u32 = 170;
/// Depth of compounds in compounds.
pub(super) const MOST_WITHIN: usize = 2;
/// Most times that a compound or an action without repetitions is done.
const MOST_TIMES: u32 = 12;

/// Gaits of which none goes to the side.
const WALKS: [&str; 6] = ["walk", "walk_backward", "run", "jog_forward", "step_forward", "step_back"];
/// A short way of what has no steps that are counted (m).
const SHORT: f64 = 0.3;
/// Duration of what is done "for a while" (s).
const WHILE: f64 = 8.0;

/// Words that say a turn once more: "about turn! A full 180 over the left shoulder".
const AGAIN: [&str; 8] = ["degrees", "a", "full", "whole", "over", "the", "shoulder", "your"];

/// Words that say nothing beside a number or a limb.
pub(super) const LIMBS_AND_UNITS: [&str; 10] =
    ["hand", "foot", "knee", "step", "pace", "turn", "times", "circle", "one", "other"];

/// Reads sentences by the phrases of a grammar.
#[derive(Debug)]
pub struct Reader<'a> {
    pub(super) grammar: &'a Grammar,
    pub(super) phrases: Phrases,
    pub(super) learned: Learned,
    pub(super) situations: Situations,
}

/// The action before.
#[derive(Default)]
pub(super) struct Before {
    /// True if nobody said its side.
    is_free: bool,
    /// Words that explained it.
    words: BTreeSet<String>,
    /// The word that joined it to the one before.
    join: Option<Join>,
}

/// One piece of a sentence.
pub(super) struct Piece {
    pub join: Join,
    pub words: Vec<String>,
    pub fit: Option<Fit>,
}

impl<'a> Reader<'a> {
    /// Returns a reader of sentences.
    ///
    /// # Errors
    /// [`LanguageError::Grammar`] for a lexicon with verbs that the grammar has not.
    pub fn new(grammar: &'a Grammar) -> Result<Self, LanguageError> {
        let phrases = Phrases::new(grammar)?;
        let situations = Situations::new(&phrases)?;
        let learned = Learned::new(grammar, &phrases)?;
        Ok(Self { grammar, phrases, learned, situations })
    }

    /// Returns the verbs.
    pub fn grammar(&self) -> &'a Grammar {
        self.grammar
    }

    /// Adds the actions that a piece means.
    pub(super) fn perform(&self, script: &mut Script, piece: &Piece, before: &mut Before, depth: usize) {
        let said = said(&piece.words);
        let Some(fit) = &piece.fit else { return };
        match fit.meaning {
            Meaning::Verb(verb) => {
                let verb = &self.grammar.verbs[verb];
                let (verb, said) = self.facing(verb, &piece.words, said, &mut script.notes);
                let verb = self.on_the_way_back(verb, &piece.words, script);
                if let Some(because) = beyond(verb, &said) {
                    let (said, nearest) = (piece.words.join(" "), Some(verb.name.clone()));
                    script.impossible.push(Impossible { said, because, nearest, at: script.clauses.len() });
                    return;
                }
                let said = paced(of_supporting_leg(verb, &piece.words, said), &mut script.notes);
                let last = script.clauses.iter().rev().find(|one| one.actions[0].verb != "stand");
                let said = back_again(verb, &piece.words, said, last);
                let verb = self.both_ways(verb, &said);
                let single = matches!(verb.side, Some(Side::Left | Side::Right)) || verb.is_of_each_hand();
                if single && said.side == Some(Side::Both) && said.in_turn {
                    self.in_turn(script, verb, &said);
                    return;
                }
                let said = Said { count: said.count.or(self.some(verb, &piece.words)), ..said };
                let (action, times) = self.action(verb, &said, &mut script.notes);
                // "Bend down, pick something up" is one movement in two phrases.
                let is_posture = piece.join == Join::While;
                let is_same = ends_with(script, &action, is_posture)
                    && action.degrees.is_none()
                    && (is_posture || before.words != fit.explained);
                before.words.clone_from(&fit.explained);
                if is_same && (is_posture || matches!(piece.join, Join::And | Join::Comma)) && said.used.is_empty() {
                    return;
                }
                // "About face! 180": the same turn in a number.
                let same_turn = self.is_turn(&action)
                    && ends_with(script, &action, false)
                    && piece.words.iter().all(|word| said.used.contains(word) || AGAIN.contains(&word.as_str()));
                if same_turn {
                    return;
                }
                // "Applaud! Eight claps": how often the same is done.
                let only_counts = piece.words.len() == 1 + said.used.len() && said.count.is_some();
                if let Some(last) = script.clauses.last_mut().filter(|_| only_counts) {
                    let plain = Action { count: None, ..action.clone() };
                    // "Squat and raise your arms together, six times", too.
                    if let Some(same) = last.actions.iter_mut().find(|one| **one == plain) {
                        last.times = if action.count.is_none() { times } else { last.times };
                        (*same, last.seconds) = (action, said.seconds);
                        return;
                    }
                }
                let free = [before.is_free, said.side.is_none()];
                before.is_free = free[1];
                let mut action = action;
                if verb.acts == Acts::Feet {
                    action = gone_before(script, &said, &piece.words, action);
                }
                // "For a while": of what can be longer.
                let is_open =
                    action.count.is_none() && action.metres.is_none() && action.degrees.is_none() && times == 1;
                let is_held = said.holds && piece.join != Join::While && (verb.is_pose() || action.verb == "balance");
                let is_brief = said.briefly && !matches!(verb.acts, Acts::Feet);
                let brief = is_brief.then_some(BRIEF);
                let open = if said.many { Some(WHILE) } else { is_held.then_some(HOLD).or(brief) };
                let seconds = said.seconds.or(open.filter(|_| is_open));
                // "Take four seconds to raise an arm": of a pose the way there.
                let rise = said.seconds.filter(|_| said.is_way && verb.is_pose());
                let holds = piece.join == Join::And && self.is_held(verb, &piece.words);
                let join = if holds { Join::While } else { piece.join };
                if self.runs_back(verb, &piece.words, script) {
                    let turn = Action { direction: Some(Direction::Left), degrees: Some(180), ..Action::of("turn") };
                    script.clauses.push(Clause::new(vec![turn]));
                }
                if join == Join::While && matches!(before.join, Some(Join::And | Join::Comma)) {
                    action = said_before(script, action);
                }
                before.join = Some(join);
                self.add(script, join, action, seconds.filter(|_| rise.is_none()), times, free);
                if let Some(last) = script.clauses.last_mut().filter(|_| rise.is_some()) {
                    last.rise = rise;
                }
            }
            Meaning::Compound(number) if self.phrases.is_reaction(fit.meaning) => {
                let means = &self.phrases.compounds[number];
                script.notes.push(format!("read as a situation: {means}"));
                let mut whole = self.read_within(means, MOST_WITHIN);
                // "Swab the sweat off with your left wrist".
                if let ([Clause { actions, .. }], Some(side @ (Side::Left | Side::Right))) =
                    (&mut whole.clauses[..], said.sides[0])
                {
                    actions
                        .iter_mut()
                        .filter(|one| one.side == Some(side.mirrored()))
                        .for_each(|one| one.side = Some(side));
                }
                script.clauses.extend(whole.clauses);
            }
            Meaning::Compound(number) if depth > 0 => {
                let mut whole = self.read_within(&self.phrases.compounds[number], depth - 1);
                let actions = whole.clauses.iter_mut().flat_map(|clause| &mut clause.actions);
                actions.for_each(|action| action.mood = action.mood.or(said.mood));
                let times = said.count.unwrap_or(1).clamp(1, MOST_TIMES);
                (0..times).for_each(|_| script.clauses.extend(whole.clauses.iter().cloned()));
            }
            Meaning::Compound(_) | Meaning::Instead(_) => {}
        }
    }

    /// Reads a sentence. Its phrases may mean sentences, to a depth.
    pub(super) fn read_within(&self, text: &str, depth: usize) -> Script {
        let mut script = Script::default();
        let mut before = Before::default();
        let mut last_verb: Option<String> = None;
        let words = spelt(&self.phrases, normal(text), &mut script.notes);
        let words = without_negations(words, &mut script.notes);
        let words = self.opened(self.counted_words(held_together(words)));
        for mut group in self.grouped(pieces(&words)) {
            if let (None, Some(verb)) = (&group.fit, &last_verb) {
                self.repeat_verb(&mut group, verb);
            }
            let is_main = |word: &&String| self.phrases.is_main_verb(word);
            last_verb = group.words.iter().find(is_main).cloned().or(last_verb);
            if group.fit.is_none() {
                self.find_verb(&mut group, &script);
            }
            match group.fit.as_ref().map(|fit| (fit, fit.meaning)) {
                Some((fit, Meaning::Verb(_) | Meaning::Compound(_))) => {
                    self.leftover(&group.words, &said(&group.words), fit, &mut script.unknown);
                    self.perform(&mut script, &group, &mut before, depth);
                }
                Some((_, Meaning::Instead(number))) => self.replace(&mut script, number, &group),
                None if group.words.iter().all(|word| self.phrases.filler.contains(word)) => {}
                None => script.unknown.push(group.words.join(" ")),
            }
        }
        script
    }

    /// Puts the last verb before a piece that begins with where: "look at the ceiling, then at the floor".
    fn repeat_verb(&self, piece: &mut Piece, verb: &str) {
        let is_where =
            piece.words.first().is_some_and(|word| ["at", "to", "towards", "toward"].contains(&word.as_str()));
        let whole: Vec<String> = [verb.to_string()].into_iter().chain(piece.words.iter().cloned()).collect();
        if let (true, Some(fit)) = (is_where, self.fit(&whole)) {
            (piece.words, piece.fit) = (whole, Some(fit));
        }
    }

    /// Finds the verb of a piece without one: the last one again ("then 90 degrees right").
    fn find_verb(&self, piece: &mut Piece, script: &Script) {
        let said = said(&piece.words);
        let is_limb = |word: &String| LIMBS_AND_UNITS.contains(&self.phrases.base(word).as_str()) || word == "same";
        let is_said = |word: &String| said.used.contains(word) || self.phrases.filler.contains(word) || is_limb(word);
        // "The right leg, come back, then the left leg": standing is no verb to be repeated.
        let all = script.clauses.iter().rev().filter_map(|clause| clause.actions.last());
        let last = all.clone().find(|action| action.verb != "stand").or(all.clone().next());
        let last = last.and_then(|action| self.grammar.verbs.iter().position(|verb| verb.name == action.verb));
        // "Go forward, go back, then left, then right": no walk goes to the side.
        let is_aside = matches!(said.direction, Some(Direction::Left | Direction::Right)) && said.degrees.is_none();
        let aside = self.grammar.verbs.iter().position(|verb| verb.name == "walk_sideways");
        let is_walk = |verb: &usize| WALKS.contains(&self.grammar.verbs[*verb].name.as_str());
        let last = if is_aside && last.as_ref().is_some_and(is_walk) { aside } else { last };
        let names = !said.used.is_empty() || piece.words.iter().any(|word| word == "other");
        if let (Some(verb), true, true) = (last, names, piece.words.iter().all(is_said)) {
            let fit = Fit { meaning: Meaning::Verb(verb), score: 0.0, explained: BTreeSet::new(), has_verb: false };
            piece.fit = Some(fit);
            let side = script.clauses.last().and_then(|clause| clause.actions.last()).and_then(|action| action.side);
            if let (true, Some(side)) = (piece.words.iter().any(|word| word == "other"), side) {
                let limb = if self.grammar.verbs[verb].acts == Acts::Foot { "foot" } else { "hand" };
                piece.words.extend([side.mirrored().word().to_string(), limb.to_string()]);
            }
            // "To one side, then the other".
            let way =
                script.clauses.last().and_then(|clause| clause.actions.last()).and_then(|action| action.direction);
            let is_other = piece.words.iter().any(|word| word == "other");
            if let (None, Some(Direction::Left | Direction::Right), true) = (side, way, is_other) {
                piece.words.push(if way == Some(Direction::Left) { "right" } else { "left" }.into());
            }
        }
    }

    /// Returns pieces with a verb each; pieces without one belong to their neighbours.
    fn grouped(&self, pieces: Vec<(Join, Vec<String>)>) -> Vec<Piece> {
        let mut out: Vec<Piece> = Vec::new();
        let mut orphan: Vec<String> = Vec::new();
        for (join, words) in pieces {
            let fit = self.fit(&words);
            // "Walks, waving": a participle is at once.
            let is_participle =
                words.first().is_some_and(|word| is_participle(word) && self.phrases.is_main_verb(word));
            let join = if join == Join::Comma && is_participle { Join::While } else { join };
            // "One hand on the hip, the other waving": the other hand, meanwhile.
            let is_paired = out.last().is_some_and(|last| last.words.iter().any(|word| word == "one"));
            let (join, words, fit) = match of_the_other(&words).filter(|_| is_paired) {
                Some(words) => (Join::While, words.clone(), self.fit(&words)),
                None => (join, words, fit),
            };
            // "Left hand on the hip, right hand pointing": each its own.
            let hands = [out.last().and_then(|last| of_hand(&last.words)), of_hand(&words)];
            let is_other_hand = matches!(hands, [Some(one), Some(other)] if one != other);
            let join = if is_other_hand && join != Join::Then { Join::While } else { join };
            // "Crouch and stay there for 5 seconds": how long the same is held.
            if let Some(last) = out.last_mut().filter(|last| last.fit.is_some() && is_hold(&words)) {
                // "Squat and hold it" is another verb than squats.
                let holds = words[0].starts_with("hold").then(|| "hold".to_string());
                last.words.extend(holds);
                last.words.extend(words.into_iter().skip_while(|word| HOLDS.contains(&word.as_str())));
                continue;
            }
            // "Walk slowly, head down": the mood of the same.
            let is_mood = words.iter().any(|word| word == "head") && said(&words).mood.is_some();
            let is_more = is_mood && join != Join::Then && join != Join::While;
            if let Some(last) = out.last_mut().filter(|_| is_more) {
                last.words.extend(words);
                continue;
            }
            // "Sidestep left, 3 small steps": more words about the same.
            // "Raise an arm, two steps right": steps are no more words about an arm.
            let walks_on = fit.as_ref().is_some_and(|fit| self.is_of_feet(fit) && fit.has_verb)
                && out.last().and_then(|last| last.fit.as_ref()).is_some_and(|fit| !self.is_of_feet(fit));
            let adds = matches!(join, Join::Comma | Join::With) && !walks_on;
            if let Some(last) = out.last_mut().filter(|last| adds && last.fit.is_some()) {
                let more = said(&words);
                let tells =
                    |word: &String| more.used.contains(word) || word == "step" || word == "steps" || word == "times";
                let ways = [more.direction, said(&last.words).direction];
                let turns_over = matches!(ways, [Some(own), Some(other)] if own != other);
                if turns_over && words.iter().all(tells) {
                    // "Two steps right, two steps left": the same again.
                    out.push(Piece { join: Join::Then, words, fit: None });
                    continue;
                }
                if !more.used.is_empty() && words.iter().all(tells) {
                    last.words.extend(words);
                    continue;
                }
            }
            // "The right arm four times and the left one twice": each its own count.
            if out.last().is_some_and(|last| fit.is_none() && self.counts_apart(last, &words)) {
                out.push(Piece { join: Join::Then, words, fit: None });
                continue;
            }
            if let Some(last) = out.last_mut().filter(|_| matches!(join, Join::And | Join::With)) {
                let merged: Vec<String> = last.words.iter().chain(&words).cloned().collect();
                // One phrase for both, such as "bend down and pick something up".
                // "Three steps ahead and two back" are two.
                let [one, other] = [said(&last.words), said(&words)];
                let are_two = one.count.is_some() && other.count.is_some();
                let keeps = |new: &Fit| last.fit.as_ref().is_some_and(|old| self.keeps_verb(old, new));
                if !are_two && self.fit(&merged).is_some_and(|fit| keeps(&fit) && self.explains_all(&merged, &fit)) {
                    last.words = merged;
                    last.fit = self.fit(&last.words);
                    continue;
                }
            }
            let is_posture = |words: &[String], fit: &Fit| {
                !fit.has_verb
                    && self.is_manner(words, fit)
                    && self.is_of_arms(fit)
                    && out.last().is_some_and(|last| last.fit.is_some())
            };
            // In a row of actions a posture is one more: "lift a knee, put it down, hands up".
            // "Walk proudly and hands on hips", too.
            let postured = matches!(join, Join::Comma | Join::And)
                && out.len() == 1
                && fit.as_ref().is_some_and(|fit| is_posture(&words, fit));
            let stands = match (&fit, join) {
                // "with" begins what is done at once only where it is a whole phrase: "with arms crossed".
                (Some(fit), Join::With) => {
                    self.is_manner(&words, fit) && out.last().is_some_and(|last| last.fit.is_some())
                }
                // "Walk backwards, hands behind your head" is the same without "with".
                (Some(fit), Join::Comma) if is_posture(&words, fit) => true,
                (Some(_), Join::And) if postured => true,
                // "A curtsy, a twirl, a curtsy": a way of the feet is an action without a verb, too.
                (Some(fit), Join::And | Join::Comma) => {
                    fit.has_verb || out.is_empty() || self.is_of_feet(fit) && self.explains_all(&words, fit)
                }
                (fit, _) => fit.is_some() || matches!(join, Join::Then) && out.is_empty(),
            };
            let join = if (join == Join::With || postured) && stands { Join::While } else { join };
            if stands || out.is_empty() && orphan.is_empty() && fit.is_some() {
                let words = std::mem::take(&mut orphan).into_iter().chain(words).collect();
                out.push(Piece { join, words, fit });
                continue;
            }
            match (out.last_mut(), join) {
                (Some(last), Join::And | Join::Comma | Join::With | Join::While) => last.words.extend(words),
                (Some(last), Join::Then) if self.says_more(last, &words) => {
                    last.words.extend(words);
                }
                (None, _) => orphan.extend(words),
                _ => out.push(Piece { join, words, fit: None }),
            }
        }
        if !orphan.is_empty() {
            out.push(Piece { join: Join::Then, words: orphan, fit: None });
        }
        // Words that came later may fit better: "step", "to the left". They do not take the verb away.
        for piece in &mut out {
            let fit = self.fit(&piece.words);
            let keeps = |new: &Fit| piece.fit.as_ref().is_none_or(|old| self.keeps_verb(old, new));
            if fit.as_ref().is_some_and(keeps) {
                piece.fit = fit;
            }
        }
        // A sentence that opens with words without a verb: "slowly".
        if out.len() > 1 && out[0].fit.is_none() {
            let first = out.remove(0);
            out[0].words.splice(0..0, first.words);
        }
        out
    }

    /// Returns whether words after "then" say more about the piece before: another way is another walk.
    fn says_more(&self, last: &Piece, words: &[String]) -> bool {
        let more = said(words);
        let is_aside = matches!(more.direction, Some(Direction::Left | Direction::Right));
        let walks = last.fit.as_ref().is_some_and(|fit| self.is_of_feet(fit));
        more.used.len() == words.len() && !turns_over(last, words) && !(is_aside && walks && more.degrees.is_none())
    }

    pub(super) fn fit(&self, words: &[String]) -> Option<Fit> {
        let said = said(words);
        // Of one hand, whichever.
        let of_both = said.side.filter(|_| !said.in_turn).or(said.in_turn.then_some(Side::Right));
        let side = of_both.or(said.plural.then_some(Side::Both)).or(said.singular.then_some(Side::Right));
        self.phrases.best(words, side, said.direction.is_some())
    }

    /// Returns whether a fit means locomotion.
    fn is_of_feet(&self, fit: &Fit) -> bool {
        matches!(fit.meaning, Meaning::Verb(verb) if self.grammar.verbs[verb].acts == Acts::Feet)
    }

    /// Returns whether a new fit explains the verbs that the old one did.
    fn keeps_verb(&self, old: &Fit, new: &Fit) -> bool {
        old.meaning == new.meaning
            || old.explained.iter().all(|word| {
                new.explained.contains(word) || !self.phrases.is_verb(word) && !["up", "down"].contains(&word.as_str())
            })
    }

    /// Returns whether a fit means a gesture.
    fn is_of_arms(&self, fit: &Fit) -> bool {
        matches!(fit.meaning, Meaning::Verb(verb) if matches!(self.grammar.verbs[verb].acts, Acts::Hand | Acts::Hands))
    }

    /// Returns whether words after "with" are a posture of their own, such as "arms crossed"; "a wave" is none.
    fn is_manner(&self, words: &[String], fit: &Fit) -> bool {
        let is_thing = words.first().is_some_and(|word| word == "a" || word == "an");
        !is_thing && self.explains_all(words, fit)
    }

    /// Returns whether a phrase explains every verb, and every word that says something.
    fn explains_all(&self, words: &[String], fit: &Fit) -> bool {
        let said = said(words);
        words.iter().all(|word| {
            let base = self.phrases.base(word);
            let is_filler = self.phrases.filler.contains(word) && !self.phrases.is_main_verb(word);
            fit.explained.contains(&base) || is_filler || said.used.contains(word) || word == "one"
        })
    }

    /// Keeps the words that neither a phrase nor a rule explains.
    fn leftover(&self, words: &[String], said: &Said, fit: &Fit, unknown: &mut Vec<String>) {
        let is_number = |word: &String| word.parse::<f64>().is_ok();
        for (at, word) in words.iter().enumerate() {
            let base = self.phrases.base(word);
            // "Tiptoe to the door": somewhere.
            let is_goal = self.is_of_feet(fit) && is_goal(&words[..at]);
            let is_filler = is_goal || self.phrases.filler.contains(word) || self.phrases.filler.contains(&base);
            let is_meant = self.phrases.belongs(fit.meaning, &base) || fit.explained.contains(&base);
            let explained = is_meant || said.used.contains(word) || is_filler;
            let is_limb = LIMBS_AND_UNITS.contains(&base.as_str()) && !is_number(word);
            if !explained && !is_limb && !unknown.contains(word) {
                unknown.push(word.clone());
            }
        }
    }

    /// Returns the action of a verb with what is said of it, and the times that it is done as a whole.
    pub(super) fn action(&self, verb: &Verb, said: &Said, notes: &mut Vec<String>) -> (Action, u32) {
        let asked = verb;
        let verb = self.counted_by_one(verb, said);
        let mut action = Action { side: verb.side, direction: verb.direction, ..Action::of(&verb.name) };
        if matches!(verb.side, Some(Side::Left | Side::Right)) {
            match said.side {
                Some(side @ (Side::Left | Side::Right)) => action.side = Some(side),
                Some(Side::Both) => notes.push(format!("'{}' is done with one {}", name(verb), limb(verb))),
                None => {}
            }
        }
        if verb.side == Some(Side::Both) && said.names_one_hand() && verb.is_of_each_hand() {
            action.side = said.sides[0];
        } else if said.one_hand && said.side.is_none() && verb.is_of_each_hand() {
            action.side = Some(Side::Right);
        } else if verb.side == Some(Side::Both) && said.names_one_hand() {
            notes.push(format!("'{}' is done with both hands", name(verb)));
        }
        if matches!(verb.direction, Some(Direction::Left | Direction::Right)) {
            match said.direction {
                Some(way) => action.direction = Some(way),
                None if verb.synth == Some(Synth::Turn) => {}
                // "Over the left shoulder" says it, too.
                None if matches!(said.side, Some(Side::Left | Side::Right)) => {
                    let is_left = said.side == Some(Side::Left);
                    action.direction = Some(if is_left { Direction::Left } else { Direction::Right });
                }
                None => notes.push(format!("'{}' to the {}: no side was said", name(verb), way(action.direction))),
            }
        }
        let mut rounds = 1;
        match verb.synth {
            Some(Synth::Turn) => {
                // "Turn 45": that many times is an angle. A small turn is half of one.
                let many = said.count.filter(|n| *n >= LEAST_ANGLE);
                let usual = if said.size == Some(Size::Small) || said.few { 45 } else { 90 };
                // More than once around is done in parts.
                let whole = said.degrees.or(many).unwrap_or(usual);
                rounds = whole.div_ceil(360).max(1);
                action.degrees = Some(whole / rounds);
            }
            Some(Synth::Curve) => action.degrees = said.degrees,
            _ if verb.bends => {
                let low = (verb.name == "bow" && said.size == Some(Size::Big)).then_some(LOW_BOW);
                action.degrees = said.degrees.or(low).map(|degrees| degrees.clamp(LEAST_BENT, MOST_BENT));
            }
            _ if verb.angles => action.degrees = said.degrees.or(said.level).map(|degrees| degrees.min(MOST_LIFTED)),
            _ if said.degrees.is_some() && verb.acts == Acts::Feet => {
                notes.push(format!("'{}' has no angle", name(verb)))
            }
            _ => {}
        }
        let is_arc = verb.synth == Some(Synth::Curve);
        let travels = verb.acts == Acts::Feet
            && (verb.cycle.is_some() || matches!(verb.synth, Some(Synth::Sideways | Synth::Diagonal)))
            && verb.direction != Some(Direction::InPlace);
        match said.metres {
            Some(_) if travels => action.metres = said.metres,
            // "A circle of two metres": its diameter.
            Some(_) if is_arc => {
                action.metres = said.metres.map(|metres| if said.is_radius { 2.0 * metres } else { metres })
            }
            Some(_) => notes.push(format!("'{}' has no distance", name(verb))),
            None => {}
        }
        let mut times = rounds;
        let is_angle = verb.synth == Some(Synth::Turn) && said.count.is_some_and(|n| n >= LEAST_ANGLE);
        match (said.count.filter(|_| !is_angle), verb.count, verb.synth) {
            (Some(n), Some(rule), _) => {
                let cycles = n.saturating_sub(rule.extra).div_ceil(rule.per_cycle);
                let least = verb.cycles.map_or(0, |[fewest, _]| fewest.min(1));
                let count = rule.per_cycle * cycles.max(least) + rule.extra;
                if count != n {
                    notes.push(format!("'{}' is done {count} times, not {n}: its steps come in pairs", name(verb)));
                }
                action.count = Some(count);
            }
            (Some(n), None, _) => times = (rounds * n).clamp(1, MOST_TIMES),
            (None, ..) => {}
        }
        // "Back up a bit": half as many steps; "nod a bit": small.
        let is_short = said.few && travels && action.metres.is_none() && action.count.is_none();
        match verb.count.filter(|_| is_short) {
            Some(rule) => {
                let usual = verb.cycles.map_or(2, |[fewest, most]| (fewest + 1).min(most));
                action.count = Some(rule.per_cycle * usual.div_ceil(2) + rule.extra);
            }
            None if is_short => action.metres = Some(SHORT),
            None => {}
        }
        // An odd number of "baby steps" is done step by step.
        let of_steps = match (asked.name.as_str(), verb.name.as_str()) {
            ("small_steps", "step_forward") => Some(Size::Small),
            ("big_steps", "step_forward") => Some(Size::Big),
            _ => None,
        };
        let size = said.size.or(of_steps).or((said.few && !travels).then_some(Size::Small));
        // A bow's size is its angle.
        let size = size.filter(|_| !(verb.bends && action.degrees.is_some()));
        // Some verbs say it themselves.
        let size = size.filter(|size| {
            !matches!((verb.name.as_str(), size), ("big_steps", Size::Big) | ("small_steps", Size::Small))
        });
        (action.speed, action.size, action.mood) =
            (said.speed.filter(|_| verb.takes_speed()), size.filter(|_| verb.takes_size()), said.mood);
        let sizes = verb.takes_size() || verb.synth.is_some() || verb.angles;
        let lost = [(said.speed.is_some() && !verb.takes_speed(), "speed"), (size.is_some() && !sizes, "size")];
        for (_, what) in lost.iter().filter(|(lost, _)| *lost) {
            notes.push(format!("'{}' has no {what} of its own", name(verb)));
        }
        (action, times)
    }

    /// Takes the nearest verb for something that none does, where that needs no consent; else keeps what cannot be done.
    fn replace(&self, script: &mut Script, number: usize, piece: &Piece) {
        let instead = &self.phrases.instead[number];
        let said_words = piece.words.join(" ");
        let nearest = instead.verb.as_ref().and_then(|verb| self.grammar.verb(verb).ok());
        match nearest.filter(|_| instead.accepted) {
            Some(verb) => {
                let said = said(&piece.words);
                let (mut action, times) = self.action(verb, &said, &mut script.notes);
                action.speed = instead.speed.or(action.speed);
                script.notes.push(format!("'{said_words}' is done as '{}': {}", name(verb), instead.because));
                self.add(script, piece.join, action, said.seconds, times, [false; 2]);
            }
            None => script.impossible.push(Impossible {
                said: said_words,
                because: instead.because.clone(),
                nearest: instead.verb.clone(),
                at: script.clauses.len(),
            }),
        }
    }
}

/// Returns whether words say another way or another angle than a piece does: "90 degrees right, then 180 left".
fn turns_over(piece: &Piece, words: &[String]) -> bool {
    let [one, other] = [said(&piece.words), said(words)];
    let differ = |pair: [Option<u32>; 2]| matches!(pair, [Some(a), Some(b)] if a != b);
    // "Twice with the right, then three times": another count is done after it.
    let counts = one.count.is_some() && other.count.is_some() && one.side.is_some();
    let ways = matches!([one.direction, other.direction], [Some(a), Some(b)] if a != b);
    ways || counts || differ([one.degrees, other.degrees])
}

/// Returns whether a script ends with an action, alone or beside another one.
fn ends_with(script: &Script, action: &Action, or_beside: bool) -> bool {
    let Some(Clause { actions, .. }) = script.clauses.last() else { return false };
    actions.contains(action) && (or_beside || actions.len() == 1)
}

pub(super) fn name(verb: &Verb) -> String {
    verb.name.replace('_', " ")
}

fn limb(verb: &Verb) -> &'static str {
    if verb.acts == Acts::Foot { "foot" } else { "hand" }
}

fn way(direction: Option<Direction>) -> &'static str {
    if direction == Some(Direction::Left) { "left" } else { "right" }
}
