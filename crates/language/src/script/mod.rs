//! A sentence in free words as a script: actions of the grammar, in sequence and at once, with what is said of each.
//!
//! The main path: [`Reader::new`] → [`Reader::read`] → [`Script`], whose [`Clause`]s are performed one after the other. A
//! sentence is divided at "then", "while", commas and their kin ([`split`]). Each piece is compared with the phrases of the
//! grammar and of `lexicon.toml` ([`phrases`]); sides, numbers and adverbs are read by rule ([`said`]). Words that mean
//! nothing to it are kept and reported.

mod again;
mod asides;
mod asked;
mod beside;
mod edited;
mod exchanged;
mod geometry;
mod joined;
mod joints;
mod kept;
mod learned;
mod limbs;
mod manners;
mod meaning;
mod mirrored;
mod numbers;
mod phrases;
mod plain;
mod postures;
mod reader;
mod reading;
mod reply;
mod said;
mod situations;
mod spelling;
mod split;
mod turns;

use std::collections::BTreeSet;
use std::fmt;

use serde::{Deserialize, Serialize};

pub use asked::Asked;
pub use learned::{ReaderPlan, ReaderScore, train_reader};
pub use reader::Reader;
pub use reading::Reading;

use crate::error::LanguageError;
use crate::facts::{Action, Direction, Facts, Relation, Side, Size, Speed};
use crate::grammar::Grammar;
use crate::posture::Posture;

/// Returns the words of all phrases of a grammar and of the lexicon, those that say little left out.
///
/// # Errors
/// As [`Reader::new`].
pub fn words_of_phrases(grammar: &Grammar) -> Result<BTreeSet<String>, LanguageError> {
    Ok(phrases::Phrases::new(grammar)?.words())
}

/// A sentence as it was understood.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Script {
    /// Clauses, performed one after the other.
    #[serde(default, rename = "clause")]
    pub clauses: Vec<Clause>,
    /// Words that were not understood.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unknown: Vec<String>,
    /// Readings that were not said: corrected words, sides that were chosen, what cannot be done at once.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Requests that cannot be performed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub impossible: Vec<Impossible>,
}

/// Actions that are done at once: one, or arms on walking legs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Clause {
    /// One action, or a gesture and the legs below it.
    #[serde(rename = "action")]
    pub actions: Vec<Action>,
    /// Postures of an action that only stands, one after the other; one that moves no foot and is held during another action.
    #[serde(default, rename = "posture", skip_serializing_if = "Vec::is_empty")]
    pub postures: Vec<Posture>,
    /// Duration that was asked for (s).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// Duration of the way to a pose, where one was asked for (s).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rise: Option<f64>,
    /// Times that an action without repetitions of its own is done.
    #[serde(default = "once", skip_serializing_if = "is_once")]
    pub times: u32,
}

fn once() -> u32 {
    1
}

fn is_once(times: &u32) -> bool {
    *times == 1
}

/// Something that was asked for and cannot be done.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Impossible {
    /// The words.
    pub said: String,
    /// The reason.
    pub because: String,
    /// The nearest verb that can be done.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nearest: Option<String>,
    /// Place among the clauses where the nearest belongs.
    #[serde(default)]
    pub at: usize,
}

impl fmt::Display for Impossible {
    /// Writes the words and the reason: `cannot do 'fly': it has no wings`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cannot do '{}': {}", self.said, self.because)
    }
}

impl Clause {
    /// Returns a clause of actions of which nothing else is said.
    pub fn new(actions: Vec<Action>) -> Self {
        Self { actions, postures: Vec::new(), seconds: None, rise: None, times: 1 }
    }

    /// Returns a clause of postures.
    pub fn of_postures(postures: Vec<Posture>) -> Self {
        Self { postures, ..Self::new(vec![Action::of("stand")]) }
    }

    /// Returns whether it stands in postures; else a posture of arms is held during its action.
    pub fn is_only_postures(&self) -> bool {
        !self.postures.is_empty() && self.actions.iter().all(|action| action.verb == "stand")
    }

    /// Returns whether a network may make it: one action, once. Durations and postures are exact by rule alone.
    pub fn is_plain(&self) -> bool {
        let is_timed = self.seconds.is_some() || self.rise.is_some();
        !is_timed && self.times <= 1 && self.actions.len() == 1 && self.postures.is_empty()
    }

    /// Returns what can be checked on its motion.
    pub fn facts(&self) -> Facts {
        let relation = if self.actions.len() > 1 { Relation::While } else { Relation::Single };
        Facts { relation, actions: self.actions.clone(), held_out: None }
    }
}

/// Verbs of the head, and what a robot whose head does not turn does in their place.
const WITHOUT_HEAD: [(&str, &str); 7] = [
    ("nod", "bow"),
    ("shake_head", "twist"),
    ("look_aside", "twist"),
    ("look_around", "twist"),
    ("look_over_shoulder", "twist"),
    ("look_up", "lean_backward"),
    ("look_down", "lean_forward"),
];

impl Script {
    /// Puts the trunk in the place of the head in these verbs, which a robot cannot do, and notes it. A head that moves beside
    /// another limb is left out. Returns whether anything changed.
    pub fn without_head(&mut self, verbs: &[&str], grammar: &Grammar) -> bool {
        let mut changed = false;
        for clause in &mut self.clauses {
            for at in (0..clause.actions.len()).rev() {
                let verb = clause.actions[at].verb.clone();
                let other = WITHOUT_HEAD.iter().find(|(head, _)| *head == verb && verbs.contains(head));
                let Some(found) = other.and_then(|(_, other)| grammar.verb(other).ok()) else { continue };
                changed = true;
                if clause.actions.len() > 1 {
                    clause.actions.remove(at);
                    self.notes.push(format!("left out '{}': the robot's head does not turn", name(&verb)));
                    continue;
                }
                let instead = name(&found.name);
                self.notes.push(format!("'{}' is done as '{instead}': the robot's head does not turn", name(&verb)));
                let old = std::mem::replace(&mut clause.actions[at], Action::of(&found.name));
                clause.actions[at].direction = found.direction;
                clause.actions[at].mood = old.mood;
                clause.times = clause.times.max(old.count.unwrap_or(1));
            }
        }
        changed
    }

    /// Appends another script: it is done after this one.
    pub fn append(&mut self, mut other: Self) {
        other.impossible.iter_mut().for_each(|one| one.at += self.clauses.len());
        self.clauses.append(&mut other.clauses);
        self.unknown.append(&mut other.unknown);
        self.notes.append(&mut other.notes);
        self.impossible.append(&mut other.impossible);
    }

    /// Returns the script with postures a share of the way, and slower; nothing where no posture moves feet or trunk.
    pub fn gentler(&self, share: f64) -> Option<Self> {
        let moves = |posture: &Posture| posture.trunk.is_some() || !posture.leaves_feet();
        let mut out = self.clone();
        let mut changed = false;
        for clause in out.clauses.iter_mut().filter(|clause| clause.is_only_postures()) {
            changed |= clause.postures.iter().any(moves);
            clause.postures = clause.postures.iter().map(|posture| posture.gentler(share)).collect();
        }
        out.notes.push(format!(
            "postures are {:.0}% of what was asked for: at full size they fell in physics",
            100.0 * share
        ));
        changed.then_some(out)
    }

    /// Leaves out what cannot be done where something else can, and notes it.
    #[must_use]
    pub fn with_the_rest(mut self) -> Self {
        if !self.clauses.is_empty() {
            self.notes.extend(self.impossible.drain(..).map(|one| format!("{one}; the rest is done")));
        }
        self
    }

    /// Puts the nearest possible motion in the place of what cannot be done; what has none is left out.
    pub fn with_nearest(mut self) -> Self {
        for one in self.impossible.iter().rev() {
            let Some(verb) = &one.nearest else { continue };
            let clause = Clause::new(vec![Action::of(verb)]);
            self.clauses.insert(one.at.min(self.clauses.len()), clause);
            self.notes.push(format!("'{}' is done as '{}': {}", one.said, name(verb), one.because));
        }
        self.impossible.clear();
        self
    }
}

fn name(verb: &str) -> String {
    verb.replace('_', " ")
}

impl fmt::Display for Script {
    /// Writes the clauses in a line: `walk, forward, 2 times; then wave, right hand`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, clause) in self.clauses.iter().enumerate() {
            write!(f, "{}{clause}", if i > 0 { "; then " } else { "" })?;
        }
        Ok(())
    }
}

impl fmt::Display for Clause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let postures: Vec<String> = self.postures.iter().map(Posture::words).collect();
        let actions: Vec<String> = self.actions.iter().map(words).collect();
        match (self.postures.is_empty(), self.is_only_postures()) {
            (true, _) => write!(f, "{}", actions.join(" while: "))?,
            (false, true) => write!(f, "{}", postures.join("; then "))?,
            (false, false) => write!(f, "{} while: {}", postures.join("; then "), actions.join(" while: "))?,
        }
        if self.times > 1 {
            write!(f, ", {} times", self.times)?;
        }
        if let Some(seconds) = self.seconds {
            write!(f, ", {seconds} s")?;
        }
        if let Some(rise) = self.rise {
            write!(f, ", {rise} s to get there")?;
        }
        Ok(())
    }
}

/// Returns an action in words.
fn words(action: &Action) -> String {
    let mut all = vec![name(&action.verb)];
    all.extend(action.side.map(|side| format!("{} side", if side == Side::Both { "both" } else { side.word() })));
    let way = |direction| match direction {
        Direction::Forward => "forward",
        Direction::Backward => "backward",
        Direction::Left => "to the left",
        Direction::Right => "to the right",
        Direction::InPlace => "in place",
    };
    all.extend(action.direction.map(|direction| way(direction).to_string()));
    all.extend(action.degrees.map(|degrees| format!("{degrees} degrees")));
    all.extend(action.metres.map(|metres| format!("{metres} m")));
    all.extend(action.count.map(|n| if n == 1 { "once".into() } else { format!("{n} times") }));
    all.extend(action.speed.map(|speed| if speed == Speed::Slow { "slow" } else { "fast" }.to_string()));
    all.extend(action.size.map(|size| if size == Size::Small { "small" } else { "big" }.to_string()));
    all.extend(action.mood.map(|mood| mood.word().to_string()));
    all.join(", ")
}

#[cfg(test)]
mod tests;
