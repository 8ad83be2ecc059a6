//! From the network's stretches of words to pieces of a sentence.

use std::sync::{LazyLock, OnceLock};

use super::network::{Network, Packed, Span, most_likely};
use super::{IMPOSSIBLE, OTHER, POSTURE};
use crate::error::LanguageError;
use crate::grammar::Grammar;
use crate::script::phrases::{Meaning, Phrases, label_of};
use crate::script::split::{Join, is_participle};

/// Words that end no action.
const JOINS: [&str; 9] = ["with", "and", "while", "then", "before", "after", "as", "|", ","];
pub(super) const WEIGHTS: &[u8] = include_bytes!("reader.safetensors");

/// The network with its labels in terms of a grammar.
pub(in crate::script) struct Learned {
    network: &'static Network,
    packed: OnceLock<Packed>,
    /// Meaning of each label; nothing for a verb that the grammar has not.
    meanings: Vec<Option<Taken>>,
}

impl std::fmt::Debug for Learned {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Learned").field("labels", &self.meanings.len()).finish_non_exhaustive()
    }
}

/// Meaning of some words.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::script) enum Taken {
    /// An action, or several.
    For(Meaning),
    /// Something that nothing here can do.
    Impossible,
    /// A movement that no verb is.
    Other,
    /// A description of limbs.
    Posture,
}

/// Words of a sentence that ask for one action.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::script) struct Stretch {
    pub join: Join,
    pub words: Vec<String>,
    pub taken: Taken,
    /// Probability that the words are one action, and this one.
    pub certainty: f64,
}

impl Learned {
    /// Returns the network that comes with the program, in terms of a grammar and its phrases.
    pub fn new(grammar: &Grammar, phrases: &Phrases) -> Result<Self, LanguageError> {
        static READ: LazyLock<Result<Network, String>> =
            LazyLock::new(|| Network::load(WEIGHTS).map_err(|e| e.to_string()));
        let network = READ.as_ref().map_err(|error| LanguageError::Grammar(error.clone()))?;
        let compound = |label: &String| phrases.compounds.iter().position(|text| label_of(text) == *label);
        let verb = |label: &String| grammar.verbs.iter().position(|verb| verb.name == *label);
        let taken = |label: &String| match label.as_str() {
            IMPOSSIBLE => Some(Taken::Impossible),
            OTHER => Some(Taken::Other),
            POSTURE => Some(Taken::Posture),
            _ => verb(label).map(Meaning::Verb).or_else(|| compound(label).map(Meaning::Compound)).map(Taken::For),
        };
        Ok(Self { network, packed: OnceLock::new(), meanings: network.labels.iter().map(taken).collect() })
    }

    /// Returns whether the network was trained on a meaning.
    pub fn knows(&self, meaning: Meaning) -> bool {
        self.meanings.contains(&Some(Taken::For(meaning)))
    }

    /// Returns the actions that a sentence asks for, in the order in which they are done.
    pub fn read(&self, words: &[String]) -> Vec<Stretch> {
        let spans = self.network.spans(self.packed.get_or_init(|| self.network.packed()), words);
        let mut out: Vec<Stretch> = Vec::new();
        let mut end = 0;
        let mut is_swapped = false;
        for (number, span) in spans.iter().enumerate() {
            let between = &words[end..span.words.start];
            // A join at the end of a stretch belongs to the next one.
            let joins =
                words[span.words.clone()].iter().rev().take_while(|word| JOINS.contains(&word.as_str())).count();
            end = (span.words.end - joins).max(span.words.start + 1);
            let inside = &words[span.words.start..end];
            let Some((taken, certainty)) = self.taken(span) else { continue };
            let mut stretch = Stretch { join: join(between, inside), words: inside.to_vec(), taken, certainty };
            // The last of a list is one more of it: "wave, bow, and clap".
            let is_list =
                out.iter().skip(1).any(|one| one.join == Join::Comma) || between.iter().any(|word| word == ",");
            if stretch.join == Join::And && is_list {
                stretch.join = Join::Then;
            }
            // "Walk, stop, and salute" is one after the other.
            let stops = out.last().and_then(|last| last.words.last()).is_some_and(|word| word.starts_with("stop"));
            if stops && stretch.join == Join::And {
                stretch.join = Join::Then;
            }
            let comes_first = number > 0 && is_after(between);
            match out.len().checked_sub(1) {
                // "Wave after the bow", "before you wave, bow".
                Some(last) if comes_first || is_swapped => {
                    stretch.join = Join::Then;
                    out.insert(last, stretch);
                }
                Some(0) if out[0].join == Join::While => {
                    // "While walking, nod".
                    stretch.join = Join::While;
                    out.push(stretch);
                }
                _ => out.push(stretch),
            }
            is_swapped = number == 0 && between.iter().any(|word| word == "before");
        }
        if let (Some(last), true) = (out.last_mut(), has_at_once(&words[end..])) {
            last.join = Join::While;
        }
        if let Some(first) = out.first_mut() {
            first.join = Join::Then;
        }
        out
    }

    /// Returns the likeliest action for a text as a whole, and its probability.
    pub fn likeliest(&self, words: &[String]) -> Option<(Meaning, f64)> {
        let packed = self.packed.get_or_init(|| self.network.packed());
        let whole = Span { words: 0..words.len(), certainty: 1.0, labels: self.network.label(packed, words)? };
        match self.taken(&whole)? {
            (Taken::For(meaning), probability) => Some((meaning, probability)),
            _ => None,
        }
    }

    /// Returns the likeliest meaning of a stretch that the grammar has, with its probability.
    fn taken(&self, span: &Span) -> Option<(Taken, f64)> {
        let known: Vec<f32> =
            span.labels.iter().zip(&self.meanings).map(|(p, taken)| if taken.is_some() { *p } else { -1.0 }).collect();
        let label = most_likely(&known);
        let certainty = f64::from(span.certainty * known[label].max(0.0));
        self.meanings.get(label).copied().flatten().map(|taken| (taken, certainty))
    }
}

/// Returns what joins a stretch to the one before it, by the words between them and its own first ones.
fn join(between: &[String], inside: &[String]) -> Join {
    let first = inside.first().map_or("", String::as_str);
    let has = |all: &[&str]| between.iter().any(|word| all.contains(&word.as_str()));
    const DURING: [&str; 6] = ["while", "whilst", "as", "during", "meanwhile", "simultaneously"];
    match () {
        () if has(&DURING) || DURING.contains(&first) || has_at_once(between) => Join::While,
        () if has(&["start", "starts", "begin", "begins"]) => Join::Then,
        () if has(&["then", "|", "next", "after", "afterwards", "finally", "before", "followed", "once", "until"]) => {
            Join::Then
        }
        () if has(&["with"]) || first == "with" => Join::While,
        () if has(&[","]) && is_participle(first) => Join::While,
        () if between.last().is_some_and(|word| word == "and") || first == "and" => Join::And,
        () => Join::Comma,
    }
}

fn has_at_once(words: &[String]) -> bool {
    let has = |text: &[&str]| words.windows(text.len()).any(|some| some.iter().eq(text.iter()));
    has(&["at", "the", "same", "time"]) || has(&["at", "once"]) || has(&["simultaneously"]) || has(&["together"])
}

/// Returns whether what follows is done first: "after", not "after that".
fn is_after(between: &[String]) -> bool {
    let at = between.iter().position(|word| word == "after");
    let that = ["that", "this", "which", "wards"];
    at.is_some_and(|at| between.get(at + 1).is_none_or(|next| !that.contains(&next.as_str())))
        && !between.iter().any(|word| word == "|" || word == ",")
}
