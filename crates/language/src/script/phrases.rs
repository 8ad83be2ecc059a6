//! Phrases of verbs as weighted words, and how well a piece of text fits them.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;

use super::meaning::is_english;
use crate::error::LanguageError;
use crate::facts::{Side, Speed};
use crate::grammar::words::{Form, inflected};
use crate::grammar::{Acts, Grammar};

const LEXICON: &str = include_str!("lexicon.toml");
/// Sentences for what people expect in situations, and of characters, one a line.
const REACTIONS: &str = include_str!("reactions.txt");

/// Weights of words: the verb, another word, one that tells phrases apart, one that says little.
const VERB: f64 = 2.0;
const WORD: f64 = 1.0;
const TOLD: f64 = 0.6;
const FILLER: f64 = 0.15;
/// Cost of a missing word, as a share of its weight.
const MISSING: f64 = 0.7;
/// Share of a phrase's weight that must be found.
const FOUND: f64 = 0.76;
/// Cost of a phrase for the other number of hands.
const OTHER_SIDE: f64 = 1.2;
/// Gain of a phrase for the verb that comes first.
const FIRST: f64 = 1.0;
/// Cost of a side that a phrase needs and nobody said, and gain of one that was said.
const NO_SIDE: f64 = 0.5;
const SIDE: f64 = 0.2;
/// Verbs that say little without their object, and their weight.
const LIGHT: [&str; 10] = ["do", "make", "take", "give", "perform", "go", "get", "have", "put", "be"];
const LIGHT_VERB: f64 = 0.6;
/// Fillers that tell phrases apart.
const TELLING: [&str; 21] = [
    "up",
    "down",
    "off",
    "out",
    "over",
    "against",
    "back",
    "backward",
    "backwards",
    "forward",
    "forwards",
    "straight",
    "around",
    "front",
    "stop",
    "not",
    "no",
    "go",
    "start",
    "here",
    "near",
];
/// Fillers that a phrase cannot lack: "walk in place" is not "walk in a square".
const ESSENTIAL: [&str; 4] = ["place", "spot", "circle", "robot"];
/// Parts of the body of which one is not another.
const PARTS: [&str; 22] = [
    "back", "shoulder", "head", "nose", "foot", "toe", "chin", "chest", "hip", "belly", "stomach", "ear", "eye",
    "mouth", "brow", "forehead", "heart", "neck", "face", "hair", "knee", "elbow",
];
/// Verbs that are things after an article.
const THINGS: [&str; 10] = ["box", "hammer", "saw", "comb", "drum", "paint", "phone", "bowl", "bat", "duck"];
const ARTICLES: [&str; 9] = ["a", "an", "the", "your", "his", "her", "my", "their", "its"];
/// Past tenses that no rule makes.
const IRREGULAR: [(&str, &str); 34] = [
    ("took", "take"),
    ("taken", "take"),
    ("stood", "stand"),
    ("went", "go"),
    ("gave", "give"),
    ("threw", "throw"),
    ("thrown", "throw"),
    ("held", "hold"),
    ("shook", "shake"),
    ("drank", "drink"),
    ("ran", "run"),
    ("swam", "swim"),
    ("flew", "fly"),
    ("sat", "sit"),
    ("lay", "lie"),
    ("lying", "lie"),
    ("bent", "bend"),
    ("knelt", "kneel"),
    ("spun", "spin"),
    ("leant", "lean"),
    ("leapt", "leap"),
    ("swung", "swing"),
    ("said", "say"),
    ("did", "do"),
    ("done", "do"),
    ("made", "make"),
    ("put", "put"),
    ("hit", "hit"),
    ("crept", "creep"),
    ("running", "run"),
    ("sitting", "sit"),
    ("swimming", "swim"),
    ("stopping", "stop"),
    ("putting", "put"),
];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Lexicon {
    filler: String,
    also: Vec<Also>,
    compound: Vec<Compound>,
    instead: Vec<Instead>,
}

/// Phrases that mean several actions.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Compound {
    say: Vec<String>,
    /// A sentence with the same meaning.
    means: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Also {
    verb: String,
    say: Vec<String>,
}

/// Phrases of motion that no verb has.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Instead {
    say: Vec<String>,
    /// The nearest verb.
    pub verb: Option<String>,
    /// Speed of that verb.
    pub speed: Option<Speed>,
    /// Reason why the motion itself is impossible.
    pub because: String,
    /// True if the nearest verb is performed without `--nearest`.
    pub accepted: bool,
}

/// Meaning of a phrase.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Meaning {
    /// A verb, by its number in the grammar.
    Verb(usize),
    /// Several actions, by their number in the lexicon.
    Compound(usize),
    /// Something else, by its number in the lexicon.
    Instead(usize),
}

/// A phrase as weighted words.
#[derive(Debug)]
struct Phrase {
    meaning: Meaning,
    text: String,
    /// The inflected word; phrases without one must be found whole.
    verb: Option<String>,
    words: Vec<(String, f64)>,
    /// Words as they are written, those that say little left out.
    written: Vec<String>,
    /// Hands that act: one, both, or none.
    side: Option<Side>,
    /// True if it has a slot for a side or an angle.
    sided: bool,
}

/// A phrase that fits.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Fit {
    pub meaning: Meaning,
    pub score: f64,
    /// Words of the text that it explains.
    pub explained: BTreeSet<String>,
    /// True if the phrase has a verb.
    pub has_verb: bool,
}

/// All phrases.
#[derive(Debug)]
pub(super) struct Phrases {
    all: Vec<Phrase>,
    pub instead: Vec<Instead>,
    /// Sentences of compounds: those that phrases name, then those that only the network chooses.
    pub compounds: Vec<String>,
    /// Number of those that phrases name.
    named: usize,
    /// Base forms by inflected form.
    forms: BTreeMap<String, String>,
    pub filler: BTreeSet<String>,
    /// Words that mean something.
    pub vocabulary: BTreeSet<String>,
}

/// Returns the name of a compound among the labels of marked sentences.
pub(super) fn label_of(compound: &str) -> String {
    format!("={compound}")
}

/// Returns the sentences of compounds, in one line each.
fn sentences(lexicon: &Lexicon) -> Vec<String> {
    let named = lexicon.compound.iter().map(|compound| compound.means.replace('\n', " "));
    named.chain(REACTIONS.lines().map(str::to_owned)).collect()
}

impl Phrases {
    /// Collects the phrases of a grammar and of the lexicon.
    pub fn new(grammar: &Grammar) -> Result<Self, LanguageError> {
        let lexicon: Lexicon = toml::from_str(LEXICON).map_err(|e| LanguageError::Grammar(format!("lexicon: {e}")))?;
        let mut texts: Vec<(Meaning, Option<Side>, String)> = Vec::new();
        for (number, verb) in grammar.verbs.iter().enumerate() {
            let also = lexicon.also.iter().filter(|also| also.verb == verb.name).flat_map(|also| &also.say);
            let phrases = verb.say.iter().chain(&verb.new).chain(also);
            let side = verb.side.filter(|_| matches!(verb.acts, Acts::Hand | Acts::Hands));
            texts.extend(phrases.map(|text| (Meaning::Verb(number), side, text.clone())));
        }
        for also in &lexicon.also {
            grammar.verb(&also.verb)?;
        }
        for (number, compound) in lexicon.compound.iter().enumerate() {
            texts.extend(compound.say.iter().map(|text| (Meaning::Compound(number), None, text.clone())));
        }
        for (number, instead) in lexicon.instead.iter().enumerate() {
            if let Some(verb) = &instead.verb {
                grammar.verb(verb)?;
            }
            texts.extend(instead.say.iter().map(|text| (Meaning::Instead(number), None, text.clone())));
        }
        let mut forms = BTreeMap::new();
        for (_, _, text) in &texts {
            for word in text.split('[').skip(1).filter_map(|rest| rest.split(']').next()) {
                // A hyphenated verb is several words of the text.
                let Some(first) = word.split('-').next() else { continue };
                forms.insert(past(first), first.to_string());
                for form in Form::ALL {
                    forms.insert(inflected(&format!("[{first}]"), form), first.to_string());
                }
            }
        }
        forms.extend(IRREGULAR.map(|(form, base)| (form.to_string(), base.to_string())));
        let filler: BTreeSet<String> = lexicon.filler.split_whitespace().map(str::to_string).collect();
        let compounds = sentences(&lexicon);
        let mut own = Self {
            all: Vec::new(),
            instead: lexicon.instead,
            named: lexicon.compound.len(),
            compounds,
            forms,
            filler,
            vocabulary: BTreeSet::new(),
        };
        own.all = texts.into_iter().map(|(meaning, side, text)| own.phrase(meaning, side, text)).collect();
        let words = own.all.iter().flat_map(|phrase| phrase.words.iter().map(|(word, _)| word.clone()));
        own.vocabulary = words.chain(own.forms.keys().cloned()).chain(own.filler.iter().cloned()).collect();
        Ok(own)
    }

    fn phrase(&self, meaning: Meaning, side: Option<Side>, text: String) -> Phrase {
        let verb = text.split('[').nth(1).and_then(|rest| rest.split([']', '-']).next()).map(str::to_string);
        let slots = [("{hand}", "hand"), ("{arm}", "hand"), ("{foot}", "foot"), ("{leg}", "foot"), ("{knee}", "knee")];
        let plain = slots.iter().fold(text.clone(), |text, (slot, word)| text.replace(slot, word));
        let plain: String = ["{side}", "{angle}", "{steps}"].iter().fold(plain, |text, slot| text.replace(slot, ""));
        let plain = plain.replace("{nsteps}", " steps");
        let plain: String = plain.chars().map(|c| if c.is_alphanumeric() { c } else { ' ' }).collect();
        let mut written: Vec<String> = plain.split_whitespace().map(str::to_lowercase).collect();
        if written.iter().any(|word| self.says_something(word)) {
            written.retain(|word| self.says_something(word));
        }
        let mut words: Vec<(String, f64)> = Vec::new();
        let said = |word: &&str| !["a", "an", "the", "to", "of", "at", "with"].contains(word);
        for word in plain.split_whitespace().filter(said).map(|word| self.base(word)) {
            let weight = match () {
                () if verb.as_deref() == Some(&word) && LIGHT.contains(&word.as_str()) => LIGHT_VERB,
                () if verb.as_deref() == Some(&word) => VERB,
                () if ESSENTIAL.contains(&word.as_str()) => WORD,
                () if TELLING.contains(&word.as_str()) => TOLD,
                () if self.filler.contains(&word) => FILLER,
                () => WORD,
            };
            if !words.iter().any(|(known, _)| *known == word) {
                words.push((word, weight));
            }
        }
        let sided = text.contains("{side}") || text.contains("{angle}");
        Phrase { meaning, text, verb, words, written, side, sided }
    }

    /// Returns the form that is compared: verbs without endings, nouns without plural, arms as hands and legs as feet.
    pub fn base(&self, word: &str) -> String {
        let word = match word {
            "arm" | "arms" | "hands" | "limb" | "limbs" => "hand",
            "leg" | "legs" | "feet" => "foot",
            "knees" => "knee",
            other => other,
        };
        if let Some(base) = self.forms.get(word) {
            return base.clone();
        }
        let singular = word.strip_suffix('s').filter(|w| w.len() > 2 && !w.ends_with('s'));
        singular.unwrap_or(word).to_string()
    }

    /// Returns the phrase that fits best, where one does. `side` is that of a limb; `has_way`: a
    /// direction is said.
    pub fn best(&self, words: &[String], side: Option<Side>, has_way: bool) -> Option<Fit> {
        let bases: BTreeSet<String> = words.iter().map(|word| self.base(word)).collect();
        let first = words.iter().find(|word| self.is_main_verb(word)).map(|word| self.base(word));
        // "Get back up" is not "back up".
        let is_other_verb = |word: &String| self.is_verb(word) && self.base(word) != "back";
        let backs = !words.iter().any(is_other_verb);
        // "The box" is a thing, and nobody boxes.
        let things = words.windows(2).filter(|pair| ARTICLES.contains(&pair[0].as_str()));
        let things: Vec<String> = things.map(|pair| self.base(&pair[1])).collect();
        let is_thing = |verb: &str| THINGS.contains(&verb) && things.iter().any(|thing| thing == verb);
        let has_arms = words.iter().any(|word| word == "arms");
        let all = self.all.iter().filter(|phrase| {
            let verb = phrase.verb.as_deref().unwrap_or("");
            // Arms are hands elsewhere, but nobody shakes hands by the arms.
            let shakes = verb == "shake" && phrase.written.iter().any(|word| word.starts_with("hand"));
            (backs || verb != "back") && !is_thing(verb) && !(shakes && has_arms)
        });
        let fits = all.filter_map(|phrase| phrase.fit(&bases, side, has_way, first.as_deref()));
        // Of equal ones the first.
        fits.fold(None, |best: Option<Fit>, fit| match best {
            Some(best) if best.score >= fit.score => Some(best),
            _ => Some(fit),
        })
    }

    /// Returns each phrase as a marked sentence (`{wave|waving with the left hand}`), in one of its forms.
    pub fn marked(&self, grammar: &Grammar) -> Vec<String> {
        const FORMS: [Form; 3] = [Form::Base, Form::Third, Form::Gerund];
        const SLOTS: [(&str, [&str; 3]); 9] = [
            ("{hand}", ["your right hand", "the left hand", "one hand"]),
            ("{arm}", ["your left arm", "the right arm", "one arm"]),
            ("{foot}", ["your right foot", "the left foot", "one foot"]),
            ("{leg}", ["your left leg", "the right leg", "one leg"]),
            ("{knee}", ["your right knee", "the left knee", "one knee"]),
            ("{side}", ["left", "right", "left"]),
            ("{nsteps}", [" three steps", " a few steps", " 4 steps"]),
            ("{steps}", ["", " two steps", " five steps"]),
            ("{angle}", ["", "90 degrees to the left", "halfway around"]),
        ];
        let marked = |(number, phrase): (usize, &Phrase)| {
            let name = match phrase.meaning {
                Meaning::Verb(verb) => grammar.verbs[verb].name.clone(),
                Meaning::Compound(number) => label_of(&self.compounds[number]),
                Meaning::Instead(_) => "impossible".into(),
            };
            let filled = |text: String, (slot, fills): &(&str, [&str; 3])| text.replace(slot, fills[number % 3]);
            let text = SLOTS.iter().fold(inflected(&phrase.text, FORMS[number / 3 % 3]), filled);
            format!("{{{name}|{text}}}")
        };
        (0..).zip(&self.all).map(marked).collect()
    }

    /// Returns whether a meaning is a reaction to a situation, or a character: the words around it say nothing more.
    pub fn is_reaction(&self, meaning: Meaning) -> bool {
        matches!(meaning, Meaning::Compound(number) if number >= self.named)
    }

    /// Returns the words of all phrases, those that say little left out.
    pub fn words(&self) -> BTreeSet<String> {
        self.all.iter().flat_map(|phrase| phrase.written.iter().cloned()).collect()
    }

    /// Returns whether a word counts for the meaning: no filler, or one that tells "arms up" from "arms down".
    fn says_something(&self, word: &str) -> bool {
        !self.filler.contains(word) || TELLING.contains(&word)
    }

    /// Returns whether a word is in some phrase of a meaning, or is a verb that says nothing by itself.
    pub fn belongs(&self, meaning: Meaning, base: &str) -> bool {
        let phrases = self.all.iter().filter(|phrase| phrase.meaning == meaning);
        LIGHT.contains(&base) || phrases.flat_map(|phrase| &phrase.words).any(|(word, _)| word == base)
    }

    /// Returns whether a word is in a phrase, or is English.
    pub fn is_spelt_right(&self, word: &str) -> bool {
        self.vocabulary.contains(word) || self.vocabulary.contains(&self.base(word)) || is_english(word)
    }

    /// Returns whether a word is a verb in some form.
    pub fn is_verb(&self, word: &str) -> bool {
        self.forms.contains_key(word)
    }

    /// Returns whether a word is a verb in some form, and nothing else: "turns" and "steps" are nouns, too.
    pub fn is_main_verb(&self, word: &str) -> bool {
        let base = self.forms.get(word);
        base.is_some_and(|base| !["step", "turn", "back"].contains(&base.as_str()) && !LIGHT.contains(&base.as_str()))
    }
}

impl Phrase {
    /// Returns whether the text names a part of the body in the place of this phrase's: a nose is no head.
    fn is_of_another_part(&self, bases: &BTreeSet<String>) -> bool {
        let own: Vec<&str> = self.words.iter().map(|(word, _)| word.as_str()).filter(|w| PARTS.contains(w)).collect();
        let lacks_own = own.iter().any(|part| !bases.contains(*part));
        lacks_own && PARTS.iter().any(|part| bases.contains(*part) && !own.contains(part))
    }

    fn fit(&self, bases: &BTreeSet<String>, side: Option<Side>, has_way: bool, first: Option<&str>) -> Option<Fit> {
        if self.verb.as_ref().is_some_and(|verb| !bases.contains(verb)) {
            return None;
        }
        let (mut found, mut whole) = (0.0, 0.0);
        let mut explained = BTreeSet::new();
        for (word, weight) in &self.words {
            whole += weight;
            if bases.contains(word) {
                found += weight;
                explained.insert(word.clone());
            }
        }
        // Of a short phrase every word counts, and of what cannot be done: "swing from a bar" is not "swing the arms".
        let whole_only = self.verb.is_none() || self.words.len() <= 2 || !matches!(self.meaning, Meaning::Verb(_));
        let least = if whole_only { 1.0 - 1e-9 } else { FOUND };
        // "Move to the left" says nothing without a side.
        let lacks_way = self.sided && !has_way && self.words.len() < 2;
        if found < least * whole || lacks_way || self.is_of_another_part(bases) {
            return None;
        }
        let other = match (self.side, side) {
            (Some(Side::Both), Some(Side::Left | Side::Right)) | (Some(Side::Left | Side::Right), Some(Side::Both)) => {
                OTHER_SIDE
            }
            _ => 0.0,
        };
        let sided = match (self.sided, has_way) {
            (true, true) => SIDE,
            (true, false) => -NO_SIDE,
            (false, _) => 0.0,
        };
        let leads = if self.verb.is_some() && self.verb.as_deref() == first { FIRST } else { 0.0 };
        let score = found - MISSING * (whole - found) - other + sided + leads;
        Some(Fit { meaning: self.meaning, score, explained, has_verb: self.verb.is_some() })
    }
}

/// Returns the regular past tense.
fn past(word: &str) -> String {
    let gerund = inflected(&format!("[{word}]"), Form::Gerund);
    let stem = gerund.strip_suffix("ing").unwrap_or(&gerund);
    match word.strip_suffix('y') {
        Some(before) if !before.ends_with(['a', 'e', 'o', 'u']) => format!("{before}ied"),
        _ => format!("{stem}ed"),
    }
}
