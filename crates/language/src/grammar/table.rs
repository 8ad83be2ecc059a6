//! The grammar's text as types, checked.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;

use super::score::Cycle;
use crate::checks::SignalName;
use crate::error::LanguageError;
use crate::facts::{Direction, Side};
use crate::touch::Touch;

/// The grammar that comes with the crate.
const BUILTIN: &str = include_str!("grammar.toml");

/// Part that moves in an action.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Acts {
    /// One hand.
    Hand,
    /// Both hands.
    Hands,
    /// One foot.
    Foot,
    /// The head.
    Head,
    /// The trunk and the legs under it, on the spot.
    Body,
    /// Both feet: locomotion.
    Feet,
}

/// Sign of the acting hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Limb {
    /// It moves more than the other.
    #[default]
    Energy,
    /// It reaches farther ahead than the other.
    Ahead,
    /// It reaches higher than the other.
    Up,
}

/// Measure of an action's pace.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Tempo {
    /// Time between repetitions (s).
    Period,
    /// Time from the first movement to the last (s).
    Duration,
    /// Way over the ground per time (m/s).
    Pace,
}

/// Steps made by a rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Synth {
    /// A turn on the spot.
    Turn,
    /// A walk along an arc.
    Curve,
    /// Steps to the side.
    Sideways,
    /// Steps ahead and to the side.
    Diagonal,
}

/// Feature that must be seen of an action.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Show {
    /// The acting hand rises above the shoulder.
    HandHigh,
    /// The acting hand leaves the side: it rises by a fifth of the arm's length.
    HandOut,
    /// The pelvis sinks.
    Low,
    /// A foot rises high.
    FootHigh,
    /// A foot stays off the ground.
    FootHeld,
    /// The trunk leans forward.
    Bent,
    /// The head is raised.
    LookUp,
    /// The head is lowered.
    LookDown,
    /// Both feet leave the ground at once.
    Flight,
    /// The acting foot hops while the other one is up.
    OneLeg,
    /// The feet are far apart.
    Wide,
    /// The feet are beside each other.
    Together,
}

/// Rule that counts repetitions: the signal has `per_cycle * cycles + extra` of them, and `minus` peaks more.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CountRule {
    /// The signal whose peaks are counted.
    pub signal: SignalName,
    /// Repetitions that are in no cycle.
    #[serde(default)]
    pub extra: u32,
    /// Repetitions in a cycle.
    #[serde(default = "one")]
    pub per_cycle: u32,
    /// Peaks that are no repetition.
    #[serde(default)]
    pub minus: u32,
}

fn one() -> u32 {
    1
}

fn yes() -> bool {
    true
}

/// A verb.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Verb {
    /// Name, as facts have it.
    pub name: String,
    /// Keyframed clip.
    pub clip: String,
    /// Part that moves.
    pub acts: Acts,
    /// Side of the acting limb in the clip as written.
    pub side: Option<Side>,
    /// Direction in the clip as written.
    pub direction: Option<Direction>,
    /// The stretch that repeats.
    pub cycle: Option<Cycle>,
    /// Fewest and most cycles.
    pub cycles: Option<[u32; 2]>,
    /// Rule of counting.
    pub count: Option<CountRule>,
    /// Signal of the amplitude, where there is no count.
    pub signal: Option<SignalName>,
    /// Measure of the pace.
    pub tempo: Tempo,
    /// Rule of the steps.
    pub synth: Option<Synth>,
    /// Flag of a gesture that arms can do on walking legs.
    #[serde(default)]
    pub arms: bool,
    /// Flag of arms that can be asked for an angle from hanging down.
    #[serde(default)]
    pub angles: bool,
    /// Flag of a trunk that can be asked for an angle.
    #[serde(default)]
    pub bends: bool,
    /// Flag of a clip that changed after the shipped networks learned it: rules make it.
    #[serde(default)]
    pub remade: bool,
    /// Flag of legs that carry such a gesture.
    #[serde(default)]
    pub carries: bool,
    /// Flag: its size can be said.
    #[serde(default)]
    pub sizes: bool,
    /// Flag: a mood can be said.
    #[serde(default)]
    pub moods: bool,
    /// Flag of what is done once where nobody says how often: a squat, not a wave.
    #[serde(default)]
    pub once: bool,
    /// Flag of hands that need a thing, a thumb or fingers, which a robot lacks: the words say which.
    pub lacks: Option<String>,
    /// Flag: its speed can be said.
    #[serde(default = "yes")]
    pub speeds: bool,
    /// Sign of the acting hand.
    #[serde(default)]
    pub limb: Limb,
    /// Features that must be seen.
    #[serde(default)]
    pub shows: Vec<Show>,
    /// Place that the hand touches.
    pub touches: Option<Touch>,
    /// Phrases.
    pub say: Vec<String>,
    /// Phrases of the held-out words.
    pub new: Vec<String>,
}

impl Verb {
    /// Returns whether the mirror image says something else.
    pub fn has_sides(&self) -> bool {
        matches!(self.side, Some(Side::Left | Side::Right))
            || matches!(self.direction, Some(Direction::Left | Direction::Right))
    }

    /// Returns whether its tempo can be said: that of a flight is gravity's, and standing has none.
    pub fn takes_speed(&self) -> bool {
        let is_flight = self.shows.contains(&Show::Flight) && self.tempo == Tempo::Period;
        self.speeds || self.cycle.is_some() && !is_flight
    }

    /// Returns whether its size can be said: of what repeats and can be measured, of steps, and of how far trunk and head
    /// go. Hands that go to a place have none.
    pub fn takes_size(&self) -> bool {
        let repeats = self.cycle.is_some() && self.count.is_some() && self.direction != Some(Direction::InPlace);
        let steps = self.synth == Some(Synth::Sideways);
        self.sizes || steps || repeats || self.jumps() && !self.shows.contains(&Show::OneLeg) || self.is_inclined()
    }

    /// Returns whether it only stands or sways, which is the same all the time.
    pub(super) fn is_even(&self) -> bool {
        self.acts == Acts::Body && self.shows.is_empty()
    }

    /// Returns whether it is counted in flights.
    pub fn jumps(&self) -> bool {
        self.count.is_some_and(|rule| rule.signal == SignalName::Flights)
    }

    /// Returns whether hands repeat something in the air, not above the shoulder and not at the body.
    pub fn is_free_gesture(&self) -> bool {
        let in_the_air = self.touches.is_none() && !self.shows.contains(&Show::HandHigh);
        matches!(self.acts, Acts::Hand | Acts::Hands) && self.cycle.is_some() && in_the_air
    }

    /// Returns whether it has a pose that can be held.
    pub fn is_pose(&self) -> bool {
        self.cycle.is_none() && self.acts != Acts::Feet && !self.is_even()
    }

    /// Returns whether legs go down to a pose that can be held.
    pub fn is_low_pose(&self) -> bool {
        self.is_pose() && matches!(self.acts, Acts::Foot | Acts::Body) && self.shows.contains(&Show::Low)
    }

    /// Returns whether trunk or head go somewhere and come back.
    pub fn is_inclined(&self) -> bool {
        // A bend of less than it is none.
        let goes = (!self.shows.is_empty() || self.direction.is_some()) && !self.shows.contains(&Show::Bent);
        self.cycle.is_none() && (self.acts == Acts::Head || self.acts == Acts::Body && goes && self.speeds)
    }

    /// Returns whether one of its two hands can do it alone.
    pub fn is_of_each_hand(&self) -> bool {
        use SignalName as S;
        let own = [S::HandUp, S::HandIn, S::HandForward, S::HandBack, S::HandSide, S::HandSideLow];
        let counts = self.count.is_some_and(|rule| own.contains(&rule.signal));
        self.acts == Acts::Hands && counts && self.touches.is_none() && !self.shows.contains(&Show::Low)
    }

    /// Returns the signal of the amplitude.
    pub fn amplitude(&self) -> Option<SignalName> {
        self.count.map(|count| count.signal).or(self.signal)
    }
}

/// The grammar: verbs and words.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Grammar {
    /// Subjects of sentences.
    pub subjects: Vec<String>,
    /// Held-out subjects.
    pub new_subjects: Vec<String>,
    /// Commands.
    pub imperative: Vec<String>,
    /// Held-out commands.
    pub new_imperative: Vec<String>,
    /// Two actions, one after the other.
    pub then: Vec<String>,
    /// Held-out ones.
    pub new_then: Vec<String>,
    /// Two actions at once.
    #[serde(rename = "while")]
    pub during: Vec<String>,
    /// Held-out ones.
    #[serde(rename = "new_while")]
    pub new_during: Vec<String>,
    /// Adverbs by class: of speed, size and mood.
    pub adverbs: BTreeMap<String, Vec<String>>,
    /// Held-out ones.
    pub new_adverbs: BTreeMap<String, Vec<String>>,
    /// The verbs.
    #[serde(rename = "verb")]
    pub verbs: Vec<Verb>,
}

impl Grammar {
    /// Returns the grammar that comes with the crate.
    ///
    /// # Errors
    /// As [`Self::parse`]; a test holds that there is none.
    pub fn builtin() -> Result<Self, LanguageError> {
        Self::parse(BUILTIN)
    }

    /// Reads a grammar.
    ///
    /// # Errors [`LanguageError::Grammar`] for a text that is none, a verb that stands twice or has no words, and
    /// cycles without range. A class of adverbs needs words, too.
    pub fn parse(text: &str) -> Result<Self, LanguageError> {
        let grammar: Self = toml::from_str(text).map_err(|e| LanguageError::Grammar(e.to_string()))?;
        let mut seen = BTreeSet::new();
        for verb in &grammar.verbs {
            let bad = |message: &str| Err(LanguageError::Grammar(format!("verb '{}': {message}", verb.name)));
            if !seen.insert(&verb.name) {
                return bad("expected every verb once, got it again");
            }
            if verb.say.is_empty() || verb.new.is_empty() {
                return bad("expected at least one phrase in `say` and in `new`");
            }
            if verb.cycles.is_some_and(|[fewest, most]| fewest > most)
                || (verb.cycle.is_some() && verb.cycles.is_none())
            {
                return bad("expected `cycles` as [fewest, most]");
            }
            if matches!(verb.acts, Acts::Hand | Acts::Hands | Acts::Foot) && verb.side.is_none() {
                return bad("expected the `side` of what acts");
            }
        }
        for class in ["slow", "fast", "big", "small", "sad", "proud", "angry", "happy", "tired", "afraid", "graceful"] {
            for words in [&grammar.adverbs, &grammar.new_adverbs] {
                if words.get(class).is_none_or(Vec::is_empty) {
                    return Err(LanguageError::Grammar(format!("expected adverbs for '{class}', got none")));
                }
            }
        }
        for words in [&grammar.subjects, &grammar.new_subjects, &grammar.imperative, &grammar.new_imperative] {
            if words.is_empty() {
                return Err(LanguageError::Grammar("expected subjects and commands, got none".into()));
            }
        }
        for words in [&grammar.then, &grammar.new_then, &grammar.during, &grammar.new_during] {
            if words.is_empty() {
                return Err(LanguageError::Grammar("expected templates for two actions, got none".into()));
            }
        }
        grammar.holds_words_out()?;
        Ok(grammar)
    }

    /// Returns the verb of this name.
    ///
    /// # Errors
    /// [`LanguageError::Grammar`] for a name that no verb has.
    pub fn verb(&self, name: &str) -> Result<&Verb, LanguageError> {
        let found = self.verbs.iter().find(|verb| verb.name == name);
        found.ok_or_else(|| LanguageError::Grammar(format!("expected a verb of the grammar, got '{name}'")))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_verb_of_ours_has_its_clip() {
        let grammar = Grammar::builtin().unwrap();
        let clips: Vec<&str> = lifelike_motion::keyframes::builtin().map(|(name, _)| name).collect();
        for verb in &grammar.verbs {
            assert!(clips.contains(&verb.clip.as_str()), "{}", verb.clip);
        }
        assert!(grammar.verbs.len() >= 40);
    }

    #[test]
    fn what_is_wrong_is_told() {
        for (from, to, part) in [
            ("name = \"wave\"", "name = \"clap\"", "once"),
            ("acts = \"hand\"", "acts = \"tail\"", "tail"),
            ("cycles = [1, 5]", "cycles = [5, 1]", "fewest"),
            ("slow = [\"slowly\"", "tardy = [\"slowly\"", "slow"),
            ("[polish] a pane", "[clean] a window", "verb 'wipe': expected a word in"),
        ] {
            let message = Grammar::parse(&BUILTIN.replacen(from, to, 1)).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }
}
