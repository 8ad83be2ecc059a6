//! Meaning of words as vectors.
//!
//! Each of some twenty thousand words has a vector: the sentence embedding of the word alone by all-MiniLM-L6-v2, along its
//! principal directions (`word_vectors.md`).

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::LazyLock;

use lifelike_checkpoint::Checkpoint;

use crate::error::LanguageError;

/// English words, in the order of their bytes (`word_vectors.md`).
const ENGLISH: &str = include_str!("english.txt");
const TABLE: &[u8] = include_bytes!("word_vectors.safetensors");
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

    /// Returns how many numbers a word has.
    pub fn width(&self) -> usize {
        self.scale.len()
    }

    /// Adds a word's vector. Endings are tried without; a word that is not in the table adds nothing.
    pub fn add(&self, word: &str, sum: &mut [f32]) {
        let endings = ["s", "es", "d", "ed", "ing"];
        let stems = endings.iter().filter_map(|ending| word.strip_suffix(ending)).filter(|stem| stem.len() > 2);
        let Some(&at) = std::iter::once(word).chain(stems).find_map(|form| self.index.get(form)) else { return };
        let width = self.scale.len();
        for ((sum, byte), scale) in sum.iter_mut().zip(&self.bytes[at * width..]).zip(&self.scale) {
            *sum += scale * (f32::from(*byte) - ZERO);
        }
    }
}
