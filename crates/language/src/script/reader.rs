//! From a sentence to a script.

use std::collections::BTreeSet;

use super::phrases::{Fit, Meaning, Phrases};
use super::said::{Said, said};
use super::split::{Join, normal, pieces};
use super::{Clause, Impossible, Script};
use crate::checks::SignalName;
use crate::error::LanguageError;
use crate::facts::{Action, Direction, Side};
use crate::grammar::{Acts, Grammar, Synth, Verb};

/// Longest word of which a letter may be wrong, and of which two may be, at least.
const ONE_WRONG: usize = 4;
const TWO_WRONG: usize = 8;

/// Similarity from which a text is taken for a phrase, and from which a phrase is named (`docs/results/language.md`).
const TAKEN: f64 = 0.7;
const NAMED: f64 = 0.5;
/// Similarity from which a text of known words is taken for a phrase that has not all of them.
const REORDERED: f64 = 0.85;

/// Words that say sides, numbers and limbs.
const SPELT: [&str; 20] = [
    "left",
    "right",
    "both",
    "degrees",
    "seconds",
    "steps",
    "times",
    "twice",
    "once",
    "three",
    "four",
    "five",
    "seven",
    "hand",
    "hands",
    "arms",
    "foot",
    "forward",
    "backward",
    "backwards",
];

/// Reads sentences by the phrases of a grammar.
#[derive(Debug)]
pub struct Reader<'a> {
    grammar: &'a Grammar,
    phrases: Phrases,
}

/// One piece of a sentence.
struct Piece {
    join: Join,
    words: Vec<String>,
    fit: Option<Fit>,
}

impl<'a> Reader<'a> {
    /// Returns a reader of sentences.
    ///
    /// # Errors
    /// [`LanguageError::Grammar`] for a lexicon with verbs that the grammar has not.
    pub fn new(grammar: &'a Grammar) -> Result<Self, LanguageError> {
        Ok(Self { grammar, phrases: Phrases::new(grammar)? })
    }

    /// Returns the verbs.
    pub fn grammar(&self) -> &'a Grammar {
        self.grammar
    }

    /// Reads a sentence. Everything that was not understood is in the result.
    pub fn read(&self, text: &str) -> Script {
        let mut script = Script::default();
        let words = self.spelt(normal(text), &mut script.notes);
        let words = without_negations(words, &mut script.notes);
        let words = Self::held_together(words);
        for mut group in self.grouped(pieces(&words)) {
            if group.fit.is_none() {
                self.find_verb(&mut group, &mut script);
            }
            if group.fit.is_none() {
                self.find_meaning(&mut group, &mut script.notes);
            }
            match group.fit.as_ref().map(|fit| (fit, fit.meaning)) {
                Some((fit, Meaning::Verb(verb))) => {
                    let said = said(&group.words);
                    self.leftover(&group.words, &said, fit, &mut script.unknown);
                    let verb = &self.grammar.verbs[verb];
                    let said = of_supporting_leg(verb, &group.words, said);
                    let single = matches!(verb.side, Some(Side::Left | Side::Right));
                    if single && said.side == Some(Side::Both) && said.in_turn {
                        // "Left and right": one after the other.
                        for side in [Side::Left, Side::Right] {
                            let one = Said { side: Some(side), ..said.clone() };
                            let (action, times) = self.action(verb, &one, &mut script.notes);
                            self.add(&mut script, Join::Then, action, said.seconds, times);
                        }
                        continue;
                    }
                    let (action, times) = self.action(verb, &said, &mut script.notes);
                    self.add(&mut script, group.join, action, said.seconds, times);
                }
                Some((_, Meaning::Instead(number))) => self.replace(&mut script, number, &group),
                None if group.words.iter().all(|word| self.phrases.filler.contains(word)) => {}
                None => script.unknown.push(group.words.join(" ")),
            }
        }
        script
    }

    /// Finds the verb of a piece without one: the last one again ("then 90 degrees right"), or one with a letter wrong.
    fn find_verb(&self, piece: &mut Piece, script: &mut Script) {
        let said = said(&piece.words);
        let is_said = |word: &String| said.used.contains(word) || self.phrases.filler.contains(word) || word == "same";
        let last = script.clauses.last().and_then(|clause| clause.actions.last());
        let last = last.and_then(|action| self.grammar.verbs.iter().position(|verb| verb.name == action.verb));
        if let (Some(verb), false, true) = (last, said.used.is_empty(), piece.words.iter().all(is_said)) {
            let fit = Fit { meaning: Meaning::Verb(verb), score: 0.0, explained: BTreeSet::new(), has_verb: false };
            piece.fit = Some(fit);
            return;
        }
        let mut notes = Vec::new();
        let words: Vec<String> = piece.words.iter().map(|word| self.corrected(word.clone(), &mut notes)).collect();
        if let Some(fit) = self.fit(&words).filter(|_| !notes.is_empty()) {
            (piece.words, piece.fit) = (words, Some(fit));
            script.notes.append(&mut notes);
        }
    }

    /// Corrects words of sides, numbers and limbs in which one letter is missing, doubled or exchanged with its neighbour.
    fn spelt(&self, words: Vec<String>, notes: &mut Vec<String>) -> Vec<String> {
        let known = |word: &String| {
            self.phrases.vocabulary.contains(word) || self.phrases.vocabulary.contains(&self.phrases.base(word))
        };
        let corrected = |word: String| {
            let letters = word.chars().count();
            if letters < ONE_WRONG || known(&word) || !word.chars().all(char::is_alphabetic) {
                return word;
            }
            let is_near = |target: &&&str| {
                let other_length = target.len() != word.len() || is_transposed(target, &word);
                other_length && strsim::osa_distance(target, &word) == 1 && target.chars().next() == word.chars().next()
            };
            let Some(found) = SPELT.iter().find(is_near) else { return word };
            notes.push(format!("read '{word}' as '{found}'"));
            (*found).to_string()
        };
        words.into_iter().map(corrected).collect()
    }

    /// Returns a word as it is known: of a word that nobody knows, one with a letter or two changed.
    fn corrected(&self, word: String, notes: &mut Vec<String>) -> String {
        let known = |word: &str| {
            self.phrases.vocabulary.contains(word) || self.phrases.vocabulary.contains(&self.phrases.base(word))
        };
        let letters = word.chars().count();
        let is_said = !said(std::slice::from_ref(&word)).used.is_empty();
        if letters < ONE_WRONG || known(&word) || is_said || !word.chars().all(char::is_alphabetic) {
            return word;
        }
        let allowed = if letters >= TWO_WRONG { 2 } else { 1 };
        // A letter for another makes another word too easily: "rase" is no "race".
        let swaps = |w: &String| letters < TWO_WRONG && w.len() == word.len() && !is_transposed(w, &word);
        let verbs = self.phrases.vocabulary.iter().filter(|w| self.phrases.is_verb(w) && !swaps(w));
        let near = verbs.map(|w| (strsim::osa_distance(w, &word), w));
        let begins = |w: &String| w.chars().next() == word.chars().next();
        let is_near = |(d, w): &(usize, &String)| *d <= allowed && w.len() >= ONE_WRONG && begins(w);
        let best = near.filter(is_near).min_by_key(|(d, _)| *d);
        match best {
            Some((_, found)) => {
                notes.push(format!("read '{word}' as '{found}'"));
                found.clone()
            }
            None => word,
        }
    }

    /// Drops "and" between sides, which joins no actions: "left and right".
    fn held_together(words: Vec<String>) -> Vec<String> {
        const PAIRS: [(&str, &str); 6] =
            [("left", "right"), ("right", "left"), ("up", "down"), ("fro", "to"), ("to", "fro"), ("back", "forth")];
        let word = |i: usize| words.get(i).map_or("", String::as_str);
        let joins = |i: usize| word(i) == "and" && i > 0 && PAIRS.contains(&(word(i - 1), word(i + 1)));
        (0..words.len()).filter(|i| !joins(*i)).map(|i| words[i].clone()).collect()
    }

    /// Returns pieces with a verb each; pieces without one belong to their neighbours.
    fn grouped(&self, pieces: Vec<(Join, Vec<String>)>) -> Vec<Piece> {
        let mut out: Vec<Piece> = Vec::new();
        let mut orphan: Vec<String> = Vec::new();
        for (join, words) in pieces {
            let fit = self.fit(&words);
            // "Walks, waving": a participle is at once.
            let is_participle =
                words.first().is_some_and(|word| word.ends_with("ing") && self.phrases.is_main_verb(word));
            let join = if join == Join::Comma && is_participle { Join::While } else { join };
            // "Sidestep left, 3 small steps": more words about the same.
            if let Some(last) = out.last_mut().filter(|last| join == Join::Comma && last.fit.is_some()) {
                let said = said(&words);
                let tells =
                    |word: &String| said.used.contains(word) || word == "step" || word == "steps" || word == "times";
                if said.count.is_some() && words.iter().all(tells) {
                    last.words.extend(words);
                    continue;
                }
            }
            if let Some(last) = out.last_mut().filter(|_| matches!(join, Join::And | Join::With)) {
                let merged: Vec<String> = last.words.iter().chain(&words).cloned().collect();
                // One phrase for both, such as "bend down and pick something up".
                if last.fit.is_some() && self.fit(&merged).is_some_and(|fit| self.explains_all(&merged, &fit)) {
                    last.words = merged;
                    last.fit = self.fit(&last.words);
                    continue;
                }
            }
            let stands = match (&fit, join) {
                // "with" begins what is done at once only where it is a whole phrase: "with arms crossed".
                (Some(fit), Join::With) => {
                    self.is_manner(&words, fit) && out.last().is_some_and(|last| last.fit.is_some())
                }
                (Some(fit), Join::And | Join::Comma) => fit.has_verb || out.is_empty(),
                (fit, _) => fit.is_some() || matches!(join, Join::Then) && out.is_empty(),
            };
            let join = if join == Join::With && stands { Join::While } else { join };
            if stands || out.is_empty() && orphan.is_empty() && fit.is_some() {
                let words = std::mem::take(&mut orphan).into_iter().chain(words).collect();
                out.push(Piece { join, words, fit });
                continue;
            }
            match (out.last_mut(), join) {
                (Some(last), Join::And | Join::Comma | Join::With | Join::While) => last.words.extend(words),
                (Some(last), Join::Then) if said(&words).used.len() == words.len() => last.words.extend(words),
                (None, _) => orphan.extend(words),
                _ => out.push(Piece { join, words, fit: None }),
            }
        }
        if !orphan.is_empty() {
            out.push(Piece { join: Join::Then, words: orphan, fit: None });
        }
        // Words that came later may fit better: "step", "to the left".
        for piece in &mut out {
            piece.fit = self.fit(&piece.words);
        }
        // A sentence that opens with words without a verb: "slowly".
        if out.len() > 1 && out[0].fit.is_none() {
            let first = out.remove(0);
            out[0].words.splice(0..0, first.words);
        }
        out
    }

    fn fit(&self, words: &[String]) -> Option<Fit> {
        let said = said(words);
        let side = said.side.or(said.plural.then_some(Side::Both));
        self.phrases.best(words, side, said.direction.is_some())
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
            fit.explained.contains(&base) || is_filler || said.used.contains(word)
        })
    }

    /// Keeps the words that neither a phrase nor a rule explains.
    fn leftover(&self, words: &[String], said: &Said, fit: &Fit, unknown: &mut Vec<String>) {
        let is_number = |word: &String| word.parse::<f64>().is_ok();
        for word in words {
            let base = self.phrases.base(word);
            let is_filler = self.phrases.filler.contains(word) || self.phrases.filler.contains(&base);
            let is_meant = self.phrases.belongs(fit.meaning, &base) || fit.explained.contains(&base);
            let explained = is_meant || said.used.contains(word) || is_filler;
            let is_limb =
                (["hand", "foot", "step", "turn", "times", "circle"].contains(&base.as_str())) && !is_number(word);
            if !explained && !is_limb && !unknown.contains(word) {
                unknown.push(word.clone());
            }
        }
    }

    /// Returns the action of a verb with what is said of it, and the times that it is done as a whole.
    fn action(&self, verb: &Verb, said: &Said, notes: &mut Vec<String>) -> (Action, u32) {
        let verb = self.counted_by_one(verb, said);
        let mut action = Action { side: verb.side, direction: verb.direction, ..Action::of(&verb.name) };
        if matches!(verb.side, Some(Side::Left | Side::Right)) {
            match said.side {
                Some(side @ (Side::Left | Side::Right)) => action.side = Some(side),
                Some(Side::Both) => notes.push(format!("'{}' is done with one {}", name(verb), limb(verb))),
                None => {}
            }
        }
        if matches!(verb.direction, Some(Direction::Left | Direction::Right)) {
            match said.direction {
                Some(way) => action.direction = Some(way),
                None if verb.synth == Some(Synth::Turn) => {}
                None => notes.push(format!("'{}' to the {}: no side was said", name(verb), way(action.direction))),
            }
        }
        match verb.synth {
            Some(Synth::Turn) => action.degrees = Some(said.degrees.unwrap_or(90)),
            Some(Synth::Curve) => action.degrees = said.degrees,
            _ if said.degrees.is_some() => notes.push(format!("'{}' has no angle", name(verb))),
            _ => {}
        }
        let mut times = 1;
        match (said.count, verb.count, verb.synth) {
            (Some(n), Some(rule), _) => {
                let cycles = n.saturating_sub(rule.extra).div_ceil(rule.per_cycle);
                let least = verb.cycles.map_or(0, |[fewest, _]| fewest.min(1));
                let count = rule.per_cycle * cycles.max(least) + rule.extra;
                if count != n {
                    notes.push(format!("'{}' is done {count} times, not {n}: its steps come in pairs", name(verb)));
                }
                action.count = Some(count);
            }
            (Some(n), None, Some(Synth::Sideways)) => action.count = Some(n),
            (Some(n), None, _) => times = n.clamp(1, 12),
            (None, ..) => {}
        }
        (action.speed, action.size, action.mood) =
            (said.speed.filter(|_| verb.speeds), said.size.filter(|_| verb.sizes), said.mood.filter(|_| verb.moods));
        let lost = [
            (said.speed.is_some() && !verb.speeds, "speed"),
            (said.size.is_some() && !verb.sizes, "size"),
            (said.mood.is_some() && !verb.moods, "mood"),
        ];
        for (_, what) in lost.iter().filter(|(lost, _)| *lost) {
            notes.push(format!("'{}' has no {what} of its own", name(verb)));
        }
        (action, times)
    }

    /// Returns the verb whose steps are counted one by one where an odd number is said.
    fn counted_by_one<'v>(&'v self, verb: &'v Verb, said: &Said) -> &'v Verb {
        let is_pair = verb.count.is_some_and(|rule| rule.signal == SignalName::Steps && rule.per_cycle == 2);
        let odd = said.count.is_some_and(|n| !n.is_multiple_of(2));
        let other = match verb.name.as_str() {
            "walk" => "step_forward",
            "walk_backward" => "step_back",
            _ => return verb,
        };
        if is_pair && odd { self.grammar.verb(other).unwrap_or(verb) } else { verb }
    }

    /// Appends an action: to the last clause where it is done at once with it.
    fn add(&self, script: &mut Script, join: Join, action: Action, seconds: Option<f64>, times: u32) {
        let with_last = match join {
            Join::While => true,
            // "Walks and waves" is at once; "takes two steps and waves" is not.
            Join::And => script.clauses.last().is_some_and(|last| {
                let open =
                    last.actions.iter().all(|a| a.count.is_none() && a.degrees.is_none()) && last.seconds.is_none();
                open && times == 1 && self.at_once(&last.actions, &action).is_some()
            }),
            _ => false,
        };
        let pair = script.clauses.last().filter(|_| with_last).map(|last| self.at_once(&last.actions, &action));
        match (pair, script.clauses.last_mut()) {
            (Some(Some(pair)), Some(last)) => {
                last.actions = pair;
                last.seconds = last.seconds.or(seconds);
            }
            (Some(None), Some(last)) => {
                let text = |action: &Action| action.verb.replace('_', " ");
                let before: Vec<String> = last.actions.iter().map(text).collect();
                script.notes.push(format!(
                    "'{}' cannot be done during '{}': it follows",
                    text(&action),
                    before.join(" and ")
                ));
                script.clauses.push(Clause { actions: vec![action], seconds, times });
            }
            _ => script.clauses.push(Clause { actions: vec![action], seconds, times }),
        }
    }

    /// Returns two actions that other limbs do, the upper one first; nothing where they need the same limb.
    fn at_once(&self, before: &[Action], action: &Action) -> Option<Vec<Action>> {
        let [one] = before else { return None };
        let verbs = [one, action].map(|a| self.grammar.verb(&a.verb).ok());
        let [Some(a), Some(b)] = verbs else { return None };
        if is_above((a, one), (b, action)) {
            return Some(vec![one.clone(), action.clone()]);
        }
        is_above((b, action), (a, one)).then(|| vec![action.clone(), one.clone()])
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
                self.add(script, piece.join, action, said.seconds, times);
            }
            None => script.impossible.push(Impossible {
                said: said_words,
                because: instead.because.clone(),
                nearest: instead.verb.clone(),
                at: script.clauses.len(),
            }),
        }
    }

    /// Returns the phrase that means most nearly the same as a text, where one does, and the similarity (0 to 1).
    pub fn nearest(&self, text: &str) -> Option<(String, f64)> {
        let (_, phrase, similarity) = self.phrases.nearest(&normal(text))?;
        Some((without_slots(phrase), similarity)).filter(|_| similarity > NAMED)
    }

    /// Returns the words of all phrases, those that say little left out.
    pub fn words(&self) -> BTreeSet<String> {
        self.phrases.words()
    }

    /// Takes a piece that no phrase fits for the phrase that means the same, and says so.
    fn find_meaning(&self, piece: &mut Piece, notes: &mut Vec<String>) {
        let said = said(&piece.words);
        let words: Vec<String> = piece.words.iter().filter(|word| !said.used.contains(*word)).cloned().collect();
        let Some((meaning, phrase, similarity)) = self.phrases.nearest(&words) else { return };
        if similarity < if self.phrases.has_new_word(&words) { TAKEN } else { REORDERED } {
            return;
        }
        let phrase = without_slots(phrase);
        let is_filler = |word: &&String| self.phrases.filler.contains(*word);
        let last = words.len() - words.iter().rev().take_while(is_filler).count();
        let shown = &words[words.iter().take_while(is_filler).count().min(last)..last];
        notes.push(format!("'{}' is taken for '{phrase}', similarity {similarity:.2}", shown.join(" ")));
        let explained = words.iter().map(|word| self.phrases.base(word)).collect();
        piece.fit = Some(Fit { meaning, score: 0.0, explained, has_verb: false });
    }
}

/// Returns a phrase without the marks of its slots.
fn without_slots(phrase: &str) -> String {
    phrase.replace(['[', ']', '{', '}'], "")
}

/// Drops what is not to be done: from "don't", "not" or "without" to the next word that joins.
fn without_negations(words: Vec<String>, notes: &mut Vec<String>) -> Vec<String> {
    const JOINS: [&str; 6] = ["and", "but", "then", ",", "|", "just"];
    let mut out: Vec<String> = Vec::new();
    let mut dropped: Vec<String> = Vec::new();
    for word in words {
        let begins = ["dont", "never", "without", "not", "no"].contains(&word.as_str());
        if begins || !dropped.is_empty() && !JOINS.contains(&word.as_str()) {
            if begins && out.last().is_some_and(|last| last == "do") {
                out.pop();
            }
            dropped.push(word);
            continue;
        }
        if !dropped.is_empty() {
            notes.push(format!("left out: {}", dropped.join(" ")));
            dropped.clear();
        }
        out.push(word);
    }
    if !dropped.is_empty() {
        notes.push(format!("left out: {}", dropped.join(" ")));
    }
    out
}

/// Returns whether two words differ by two neighbouring letters that changed places.
fn is_transposed(a: &str, b: &str) -> bool {
    let mut of = [a, b].map(|word| word.chars().collect::<Vec<char>>());
    of.iter_mut().for_each(|letters| letters.sort_unstable());
    of[0] == of[1]
}

/// Exchanges the side of a verb of the foot where the supporting leg is named.
fn of_supporting_leg(verb: &Verb, words: &[String], said: Said) -> Said {
    let is_leg = |word: &String| ["leg", "foot"].contains(&word.as_str());
    let stands_on = words.iter().position(|word| word == "on").is_some_and(|at| words[at..].iter().take(4).any(is_leg));
    match said.side {
        Some(side) if verb.acts == Acts::Foot && stands_on => Said { side: Some(side.mirrored()), ..said },
        _ => said,
    }
}

/// Returns whether the upper action can be laid over the lower one: by the head, or by arms that the lower one leaves free.
fn is_above((upper, above): (&Verb, &Action), (lower, below): (&Verb, &Action)) -> bool {
    match (upper.acts, lower.acts) {
        (Acts::Head, Acts::Head) => false,
        (Acts::Head, _) => true,
        (Acts::Hand | Acts::Hands, Acts::Feet | Acts::Foot) => upper.arms,
        (Acts::Hand, Acts::Hand) => upper.arms && above.side != below.side,
        _ => false,
    }
}

fn name(verb: &Verb) -> String {
    verb.name.replace('_', " ")
}

fn limb(verb: &Verb) -> &'static str {
    if verb.acts == Acts::Foot { "foot" } else { "hand" }
}

fn way(direction: Option<Direction>) -> &'static str {
    if direction == Some(Direction::Left) { "left" } else { "right" }
}
