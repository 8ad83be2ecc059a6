//! Quality of reading a prompt: words of no caption, and the distance to known captions as the cosine between weighted
//! counts (tf-idf) of words and of pairs of neighbouring words.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt;

use lifelike_language::facts::Action;
use lifelike_language::script::Reader;
use serde::{Deserialize, Serialize};

use super::prompt;
use crate::GenerationError;

/// Cosine to the nearest caption from which a prompt counts as read well.
pub const FAMILIAR: f64 = 0.5;
/// Likeness of two words (Dice coefficient of their letter pairs) from which one is named for the other: one wrong
/// letter leaves a word of four letters 0.6, and `call` has 0.4 of `cartwheel`.
const ALIKE: f64 = 0.5;

/// Known captions, with how rare their words are. As text it is the list of captions.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(from = "Vec<String>", into = "Vec<String>")]
pub struct KnownCaptions {
    captions: Vec<String>,
    words: BTreeSet<String>,
    /// Captions that have the term.
    frequency: HashMap<String, usize>,
    /// Caption and weight of the term in it, by term.
    places: HashMap<String, Vec<(usize, f64)>>,
}

/// Quality of reading a prompt.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Familiarity {
    /// Words of the prompt.
    pub words: usize,
    /// Words that are in no caption, with the most similar word that is, if any.
    pub unknown: Vec<(String, Option<String>)>,
    /// The nearest caption.
    pub nearest: String,
    /// Cosine to it, 0 to 1.
    pub similarity: f64,
}

impl KnownCaptions {
    /// Learns words from all captions and keeps at most `limit` different ones, evenly spread in alphabetical order.
    /// The first one of every word is kept whatever the limit.
    pub fn learn<'a>(captions: impl IntoIterator<Item = &'a str>, limit: usize) -> Self {
        let different: BTreeSet<String> = captions.into_iter().map(|c| prompt::words(c).join(" ")).collect();
        let stride = different.len().div_ceil(limit.max(1)).max(1);
        let mut seen = BTreeSet::new();
        let mut kept = Vec::new();
        for (i, caption) in different.into_iter().enumerate() {
            let mut new = false;
            for word in caption.split(' ') {
                new |= seen.insert(word.to_owned());
            }
            if new || i % stride == 0 {
                kept.push(caption);
            }
        }
        Self::from(kept)
    }

    /// Returns the captions, lower case and without punctuation.
    pub fn captions(&self) -> &[String] {
        &self.captions
    }

    /// Measures how well a prompt is read.
    ///
    /// # Errors
    /// [`GenerationError::Prompt`] for a text that is no sentence ([`prompt::check`]).
    pub fn familiarity(&self, text: &str) -> Result<Familiarity, GenerationError> {
        let words = prompt::words(prompt::check(text)?);
        let terms = self.weighted(&words);
        let mut cosines: BTreeMap<usize, f64> = BTreeMap::new();
        for (term, weight) in &terms {
            for (caption, other) in self.places.get(term).into_iter().flatten() {
                *cosines.entry(*caption).or_default() += weight * other;
            }
        }
        let best = cosines.into_iter().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        let (nearest, similarity) =
            best.map_or((String::new(), 0.0), |(at, cosine)| (self.captions[at].clone(), cosine.min(1.0)));
        let mut unknown: Vec<(String, Option<String>)> = Vec::new();
        for word in &words {
            if !self.words.contains(word) && !unknown.iter().any(|(known, _)| known == word) {
                unknown.push((word.clone(), self.alike(word)));
            }
        }
        Ok(Familiarity { words: words.len(), unknown, nearest, similarity })
    }

    /// Returns whether captions have the verbs of a sentence: those of `actions` are all in the nearest caption. A network
    /// makes something else of a verb that it never saw.
    ///
    /// # Errors
    /// [`GenerationError::Prompt`] for a text that is no sentence.
    pub fn has_actions(&self, text: &str, actions: &[Action], reader: &Reader<'_>) -> Result<bool, GenerationError> {
        let read = reader.read(&self.familiarity(text)?.nearest);
        let known =
            |action: &Action| read.clauses.iter().flat_map(|c| &c.actions).any(|other| other.verb == action.verb);
        Ok(actions.iter().all(known))
    }

    /// Returns the terms of a text with weights of unit norm: (count of the term) · (1 + ln((1 + N) / (1 + captions
    /// with the term))).
    fn weighted(&self, words: &[String]) -> BTreeMap<String, f64> {
        let mut weights: BTreeMap<String, f64> = BTreeMap::new();
        for term in terms(words) {
            let among = self.frequency.get(&term).copied().unwrap_or(0);
            *weights.entry(term).or_default() += 1.0 + ((1 + self.captions.len()) as f64 / (1 + among) as f64).ln();
        }
        let norm = weights.values().map(|w| w * w).sum::<f64>().sqrt();
        if norm > 0.0 {
            weights.values_mut().for_each(|w| *w /= norm);
        }
        weights
    }

    /// Returns the known word most like another, if one is like it at all.
    fn alike(&self, word: &str) -> Option<String> {
        let own = letter_pairs(word);
        let likeness = |known: &str| {
            let other = letter_pairs(known);
            2.0 * own.intersection(&other).count() as f64 / (own.len() + other.len()).max(1) as f64
        };
        let best = self
            .words
            .iter()
            .map(|known| (likeness(known), known))
            .max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(a.1)));
        best.filter(|(likeness, _)| *likeness >= ALIKE).map(|(_, known)| known.clone())
    }
}

impl From<Vec<String>> for KnownCaptions {
    fn from(captions: Vec<String>) -> Self {
        let split: Vec<Vec<String>> = captions.iter().map(|caption| prompt::words(caption)).collect();
        let words = split.iter().flatten().cloned().collect();
        let mut frequency: HashMap<String, usize> = HashMap::new();
        for caption in &split {
            for term in terms(caption).into_iter().collect::<BTreeSet<_>>() {
                *frequency.entry(term).or_default() += 1;
            }
        }
        let mut known = Self { captions, words, frequency, places: HashMap::new() };
        for (at, caption) in split.iter().enumerate() {
            for (term, weight) in known.weighted(caption) {
                known.places.entry(term).or_default().push((at, weight));
            }
        }
        known
    }
}

impl From<KnownCaptions> for Vec<String> {
    fn from(known: KnownCaptions) -> Self {
        known.captions
    }
}

impl Familiarity {
    /// Returns whether the prompt is read well: every word is known and a caption is near ([`FAMILIAR`]).
    pub fn reads_well(&self) -> bool {
        self.unknown.is_empty() && self.similarity >= FAMILIAR
    }
}

/// One line for the user.
impl fmt::Display for Familiarity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.reads_well() {
            return write!(f, "read well; nearest known: \"{}\" (similarity {:.2})", self.nearest, self.similarity);
        }
        f.write_str("may not be read well: ")?;
        for (word, alike) in &self.unknown {
            write!(f, "'{word}' is in no caption")?;
            match alike {
                Some(alike) => write!(f, " (similar: '{alike}'); ")?,
                None => f.write_str("; ")?,
            }
        }
        if self.similarity > 0.0 {
            write!(f, "nearest known: \"{}\" (similarity {:.2})", self.nearest, self.similarity)
        } else {
            f.write_str("no known caption has any of its words")
        }
    }
}

/// Returns words and pairs of neighbouring words.
fn terms(words: &[String]) -> Vec<String> {
    words.iter().cloned().chain(words.windows(2).map(|pair| pair.join(" "))).collect()
}

/// Returns the pairs of neighbouring letters of a word, its ends marked.
fn letter_pairs(word: &str) -> BTreeSet<(char, char)> {
    let letters: Vec<char> = [' '].into_iter().chain(word.chars()).chain([' ']).collect();
    letters.windows(2).map(|pair| (pair[0], pair[1])).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn known() -> KnownCaptions {
        let captions =
            ["A person waves with the right hand.", "a person waves with the left hand", "a person walks forward"];
        KnownCaptions::learn(captions, 100)
    }

    #[test]
    fn a_known_caption_is_read_well_and_a_strange_one_is_not() {
        let exact = known().familiarity("a person waves with the RIGHT hand").unwrap();
        assert!((exact.similarity - 1.0).abs() < 1e-12 && exact.reads_well());
        let strange = known().familiarity("a person does a somersault").unwrap();
        assert!(!strange.reads_well());
        let text = strange.to_string();
        assert!(
            text.contains("'somersault' is in no caption") && text.contains("nearest known: \"a person "),
            "{text}"
        );
        let wrong = known().familiarity("a person wawes").unwrap();
        assert_eq!(wrong.unknown, [("wawes".to_string(), Some("waves".to_string()))]);
        let unlike = KnownCaptions::learn(["a person calls", "call"], 10).familiarity("cartwheel").unwrap();
        assert_eq!(unlike.unknown, [("cartwheel".to_string(), None)]);
        assert!(known().familiarity("zzz").unwrap().to_string().contains("no known caption has any"));
    }

    #[test]
    fn the_cosine_is_that_of_the_hand_worked_example() {
        // Two captions, so N = 2. "x": weight 1 + ln(3/2) in both; "y", "x y": 1 + ln(3/2); "x" alone: only "x".
        let known = KnownCaptions::learn(["x y", "z"], 10);
        let found = known.familiarity("x").unwrap();
        assert!((found.similarity - 1.0 / 3f64.sqrt()).abs() < 1e-12, "{}", found.similarity);
    }

    #[test]
    fn a_limit_keeps_every_word_and_a_file_changes_nothing() {
        let many: Vec<String> = (0..200).map(|i| format!("walk w{} steps", i % 90)).collect();
        let known = KnownCaptions::learn(many.iter().map(String::as_str), 10);
        assert_eq!(known.captions().len(), 90, "every caption has a word of its own");
        let few = KnownCaptions::learn(["a b", "a c", "b c", "c b", "b a", "c a"], 2);
        assert!(few.captions().len() < 6);
        let text = serde_json::to_string(&known).unwrap();
        let again: KnownCaptions = serde_json::from_str(&text).unwrap();
        assert_eq!(again.familiarity("walk w7").unwrap(), known.familiarity("walk w7").unwrap());
    }

    #[test]
    fn bad_prompts_are_refused() {
        assert!(known().familiarity("").is_err() && known().familiarity("a\u{0}b").is_err());
    }
}
