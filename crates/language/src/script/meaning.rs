//! Phrases by the meaning of their words: what people say that no phrase has.
//!
//! Each of some ten thousand words has a vector: the sentence embedding of the word alone by all-MiniLM-L6-v2, along its
//! principal directions (`word_vectors.md`). A text is the sum of its words' vectors, rare words weighing more (Arora et
//! al. 2017, "A simple but tough-to-beat baseline for sentence embeddings"). Similarity is the cosine between two texts.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::LazyLock;

use lifelike_checkpoint::Checkpoint;

use crate::error::LanguageError;

/// English words, in the order of their bytes (`word_vectors.md`).
const ENGLISH: &str = include_str!("english.txt");
const TABLE: &[u8] = include_bytes!("word_vectors.safetensors");
/// Weight of a word is `RARE / (RARE + f)`, with `f` the share of phrases that have it.
const RARE: f64 = 0.1;
/// Zero of the stored bytes.
const ZERO: f32 = 128.0;

/// Returns whether a word, perhaps without an ending, is English.
pub(super) fn is_english(word: &str) -> bool {
    static WORDS: LazyLock<BTreeSet<&str>> = LazyLock::new(|| ENGLISH.lines().collect());
    let endings = ["", "s", "es", "d", "ed", "ing", "ly"];
    endings.iter().filter_map(|ending| word.strip_suffix(ending)).any(|stem| WORDS.contains(stem))
}

/// Vectors of words.
#[derive(Debug)]
pub(super) struct Words {
    index: BTreeMap<String, usize>,
    bytes: Vec<u8>,
    /// Value of one step of a byte, by direction.
    scale: Vec<f32>,
}

/// Phrases as vectors of unit length.
#[derive(Debug)]
pub(super) struct Meanings {
    words: &'static Words,
    weights: BTreeMap<String, f64>,
    phrases: Vec<Vec<f32>>,
}

/// The phrase that means most nearly the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Nearest {
    /// Number of the phrase.
    pub phrase: usize,
    /// Cosine, less the share of the text's words without a vector (0 to 1).
    pub similarity: f64,
}

impl Words {
    /// Returns the table that comes with the program, which is read once.
    pub fn builtin() -> Result<&'static Self, LanguageError> {
        static READ: LazyLock<Result<Words, String>> = LazyLock::new(|| Words::read().map_err(|e| e.to_string()));
        READ.as_ref().map_err(|error| LanguageError::Grammar(error.clone()))
    }

    fn read() -> Result<Self, LanguageError> {
        let broken = |e: &dyn std::fmt::Display| LanguageError::Grammar(format!("word vectors: {e}"));
        let file = Checkpoint::from_bytes(TABLE, Path::new("word_vectors.safetensors")).map_err(|e| broken(&e))?;
        let shape = |name: &str| file.entry(name).map(|entry| entry.shape().to_vec()).map_err(|e| broken(&e));
        let text = file.u8s("words", &shape("words")?).map_err(|e| broken(&e))?;
        let bytes = file.u8s("vectors", &shape("vectors")?).map_err(|e| broken(&e))?;
        let scale = file.f32s("scale", &shape("scale")?).map_err(|e| broken(&e))?;
        let text = String::from_utf8(text).map_err(|e| broken(&e))?;
        let index: BTreeMap<String, usize> = text.lines().map(str::to_string).zip(0..).collect();
        if index.len() * scale.len() != bytes.len() {
            let expected = format!("expected {} numbers, got {}", index.len() * scale.len(), bytes.len());
            return Err(broken(&expected));
        }
        Ok(Self { index, bytes, scale })
    }

    /// Adds a word's vector; false for a word without one. Endings are tried without.
    fn add(&self, word: &str, weight: f64, sum: &mut [f32]) -> bool {
        let endings = ["s", "es", "d", "ed", "ing"];
        let stems = endings.iter().filter_map(|ending| word.strip_suffix(ending)).filter(|stem| stem.len() > 2);
        let Some(&at) = std::iter::once(word).chain(stems).find_map(|form| self.index.get(form)) else { return false };
        let width = self.scale.len();
        for ((sum, byte), scale) in sum.iter_mut().zip(&self.bytes[at * width..]).zip(&self.scale) {
            *sum += weight as f32 * scale * (f32::from(*byte) - ZERO);
        }
        true
    }
}

impl Meanings {
    /// Takes phrases as words, those that say little left out.
    pub fn new(words: &'static Words, phrases: &[Vec<String>]) -> Self {
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for phrase in phrases {
            let distinct: BTreeSet<&str> = phrase.iter().map(String::as_str).collect();
            distinct.into_iter().for_each(|word| *counts.entry(word).or_default() += 1);
        }
        let weight = |n: usize| RARE / (RARE + n as f64 / phrases.len() as f64);
        let weights = counts.into_iter().map(|(word, n)| (word.to_string(), weight(n))).collect();
        let mut own = Self { words, weights, phrases: Vec::new() };
        own.phrases = phrases.iter().map(|phrase| own.vector(phrase).0).collect();
        own
    }

    /// Returns the unit vector of a text, and the share of its words' weight that has vectors.
    fn vector(&self, text: &[String]) -> (Vec<f32>, f64) {
        let mut sum = vec![0.0_f32; self.words.scale.len()];
        let (mut known, mut whole) = (0.0, 0.0);
        for word in text {
            let weight = self.weights.get(word).copied().unwrap_or(1.0);
            whole += weight;
            if self.words.add(word, weight, &mut sum) {
                known += weight;
            }
        }
        let norm = sum.iter().map(|x| x * x).sum::<f32>().sqrt().max(1e-9);
        sum.iter_mut().for_each(|x| *x /= norm);
        (sum, if whole > 0.0 { known / whole } else { 0.0 })
    }

    /// Returns the nearest phrase to a text, given as words that say something; nothing for a text without known words.
    pub fn nearest(&self, text: &[String]) -> Option<Nearest> {
        let (vector, known) = self.vector(text);
        let cosine = |phrase: &Vec<f32>| phrase.iter().zip(&vector).map(|(a, b)| a * b).sum::<f32>();
        let best = self.phrases.iter().map(cosine).enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
        let best = best.filter(|_| known > 0.0)?;
        Some(Nearest { phrase: best.0, similarity: f64::from(best.1) * known })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::grammar::Grammar;
    use crate::script::phrases::{Meaning, Phrases};

    /// Each phrase is taken out, and the nearest of the others must mean the same. Of the 1071 phrases of commit fa80f60
    /// this finds 73%, and MiniLM itself 77%.
    #[test]
    fn two_of_three_phrases_are_found_by_the_others() {
        let phrases = Phrases::new(&Grammar::builtin().unwrap()).unwrap();
        let all = phrases.written();
        let texts: Vec<Vec<String>> = all.iter().map(|(_, words)| words.clone()).collect();
        let table = Meanings::new(Words::builtin().unwrap(), &texts);
        let meant = |i: usize| -> Meaning {
            let near = |j: &usize| -> f32 { table.phrases[i].iter().zip(&table.phrases[*j]).map(|(a, b)| a * b).sum() };
            let others = (0..all.len()).filter(|&j| j != i);
            all[others.max_by(|a, b| near(a).total_cmp(&near(b))).unwrap()].0
        };
        let right = (0..all.len()).filter(|&i| meant(i) == all[i].0).count();
        let share = right as f64 / all.len() as f64;
        assert!(3.0 * share > 2.0, "{share:.3} of {}", all.len());
        println!("{share:.3} of {}", all.len());
    }

    #[test]
    fn words_without_a_vector_lower_the_similarity() {
        let words = |text: &str| text.split(' ').map(str::to_string).collect::<Vec<_>>();
        let table =
            Meanings::new(Words::builtin().unwrap(), &[words("clean window"), words("wave hand"), words("bow")]);
        let same = table.nearest(&words("clean window")).unwrap();
        assert!(same.phrase == 0 && (same.similarity - 1.0).abs() < 1e-6, "{same:?}");
        let half = table.nearest(&words("clean window xyzzyq")).unwrap();
        assert!(half.phrase == 0 && half.similarity < 0.6, "{half:?}");
        assert_eq!(table.nearest(&words("xyzzyq")), None);
        // Endings are taken off: "waved" has no vector of its own phrase, "wave" has.
        assert_eq!(table.nearest(&words("scrubbing window")).unwrap().phrase, 0);
    }
}
