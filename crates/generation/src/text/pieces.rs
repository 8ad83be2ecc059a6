//! Built-in word pieces, learned on captions: byte-pair merges of characters (Sennrich et al. 2016), read greedily by the
//! longest piece (WordPiece). A piece inside a word begins with `##`.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use serde::{Deserialize, Serialize};

use super::{MAX_TOKENS, prompt};
use crate::{FromInput, GenerationError};

/// Id of a character that no caption has.
pub const UNKNOWN: u32 = 1;
/// Pieces before the learned ones.
const SPECIAL: [&str; 2] = ["[pad]", "[unknown]"];
/// Prefix of a piece inside a word.
const INSIDE: &str = "##";
/// A pair that stands less often than this is not merged.
const MIN_COUNT: usize = 2;

/// A vocabulary of word pieces. As text it is the list of pieces, in the order of their ids.
///
/// ```
/// use lifelike_generation::text::pieces::WordPieces;
///
/// let captions = ["a person waves with the right hand", "a person walks", "the person waves"];
/// let pieces = WordPieces::learn(captions, 200)?;
/// assert_eq!(pieces.text(&pieces.encode("A person waves!")?), "a person waves");
/// # Ok::<(), lifelike_generation::GenerationError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Vec<String>", into = "Vec<String>")]
pub struct WordPieces {
    pieces: Vec<String>,
    ids: HashMap<String, u32>,
}

impl WordPieces {
    /// Learns at most `size` pieces on captions. The order of the captions does not matter.
    ///
    /// Letters and digits always have a piece, so that a word of no caption is spelled.
    ///
    /// # Errors
    /// [`GenerationError::Input`] for a size that has no room for the characters.
    pub fn learn<'a>(captions: impl IntoIterator<Item = &'a str>, size: usize) -> Result<Self, GenerationError> {
        let mut counts: BTreeMap<String, usize> = BTreeMap::new();
        for word in captions.into_iter().flat_map(prompt::words) {
            *counts.entry(word).or_default() += 1;
        }
        let letters = ('a'..='z').chain('0'..='9').collect::<BTreeSet<char>>();
        let found: BTreeSet<char> = counts.keys().flat_map(|word| word.chars()).chain(letters).collect();
        let mut vocabulary: Vec<String> = SPECIAL.map(str::to_owned).to_vec();
        vocabulary.extend(found.iter().map(char::to_string));
        vocabulary.extend(found.iter().map(|c| format!("{INSIDE}{c}")));
        if vocabulary.len() > size {
            return Err(GenerationError::mismatch("word pieces", format!("at least {}", vocabulary.len()), size));
        }
        let mut words: Vec<(Vec<usize>, usize)> = Vec::with_capacity(counts.len());
        let place: HashMap<String, usize> = vocabulary.iter().cloned().zip(0..).collect();
        for (word, count) in &counts {
            let spelled = word.chars().enumerate().map(|(i, c)| place[&inside(&c.to_string(), i > 0)]);
            words.push((spelled.collect(), *count));
        }
        while vocabulary.len() < size {
            let Some((pair, merged)) = most_frequent(&words, &vocabulary) else { break };
            let id = vocabulary.iter().position(|piece| *piece == merged).unwrap_or(vocabulary.len());
            if id == vocabulary.len() {
                vocabulary.push(merged);
            }
            for (spelled, _) in &mut words {
                merge(spelled, pair, id);
            }
        }
        Self::try_from(vocabulary)
    }

    /// Returns the number of pieces, padding and the unknown character included.
    pub fn len(&self) -> usize {
        self.pieces.len()
    }

    /// Returns whether there is no piece; never so.
    pub fn is_empty(&self) -> bool {
        self.pieces.is_empty()
    }

    /// Returns the pieces in the order of their ids.
    pub fn pieces(&self) -> &[String] {
        &self.pieces
    }

    /// Returns the ids of a prompt, at most [`MAX_TOKENS`]; later ones are not read.
    ///
    /// # Errors
    /// [`GenerationError::Prompt`] for a text that is no sentence ([`prompt::check`]).
    pub fn encode(&self, text: &str) -> Result<Vec<u32>, GenerationError> {
        let mut ids = Vec::new();
        for word in prompt::words(prompt::check(text)?) {
            self.spell(&word, &mut ids);
        }
        ids.truncate(MAX_TOKENS);
        Ok(ids)
    }

    /// Returns the text of ids, words apart. Ids that are none are shown as unknown.
    pub fn text(&self, ids: &[u32]) -> String {
        let mut text = String::new();
        for id in ids {
            let piece = self.pieces.get(*id as usize).map_or(SPECIAL[UNKNOWN as usize], String::as_str);
            match piece.strip_prefix(INSIDE) {
                Some(rest) => text.push_str(rest),
                None if text.is_empty() => text.push_str(piece),
                None => {
                    text.push(' ');
                    text.push_str(piece);
                }
            }
        }
        text
    }

    /// Appends the longest pieces that make up a word, from its beginning.
    fn spell(&self, word: &str, ids: &mut Vec<u32>) {
        let ends: Vec<usize> = word.char_indices().map(|(at, _)| at).skip(1).chain([word.len()]).collect();
        let (mut at, mut first) = (0, 0);
        while first < ends.len() {
            let longest = (first..ends.len()).rev().find_map(|last| {
                let piece = inside(&word[at..ends[last]], at > 0);
                self.ids.get(&piece).map(|id| (*id, last))
            });
            let (id, last) = longest.unwrap_or((UNKNOWN, first));
            ids.push(id);
            (at, first) = (ends[last], last + 1);
        }
    }
}

impl TryFrom<Vec<String>> for WordPieces {
    type Error = GenerationError;

    fn try_from(pieces: Vec<String>) -> Result<Self, GenerationError> {
        let special = pieces.get(..SPECIAL.len()).is_some_and(|found| found.iter().eq(&SPECIAL));
        if !special {
            let got = pieces.iter().take(SPECIAL.len()).map(String::as_str).collect::<Vec<_>>().join(", ");
            return Err(GenerationError::mismatch("first word pieces", SPECIAL.join(", "), got));
        }
        let ids: HashMap<String, u32> = pieces.iter().cloned().zip(0..).collect();
        if ids.len() != pieces.len() {
            return Err(GenerationError::mismatch("different word pieces", pieces.len(), ids.len()));
        }
        Ok(Self { pieces, ids })
    }
}

impl From<WordPieces> for Vec<String> {
    fn from(pieces: WordPieces) -> Self {
        pieces.pieces
    }
}

/// Returns a piece as the vocabulary has it.
fn inside(piece: &str, inside: bool) -> String {
    if inside { format!("{INSIDE}{piece}") } else { piece.to_owned() }
}

/// Returns the most frequent pair of neighbours and its piece; of equally frequent ones the first in the alphabet.
fn most_frequent(words: &[(Vec<usize>, usize)], vocabulary: &[String]) -> Option<((usize, usize), String)> {
    let mut counts: HashMap<(usize, usize), usize> = HashMap::new();
    for (spelled, count) in words {
        for pair in spelled.windows(2) {
            *counts.entry((pair[0], pair[1])).or_default() += count;
        }
    }
    let most = counts.values().copied().max().filter(|count| *count >= MIN_COUNT)?;
    let merged = |(a, b): (usize, usize)| {
        let rest = &vocabulary[b];
        format!("{}{}", vocabulary[a], rest.strip_prefix(INSIDE).unwrap_or(rest))
    };
    let best = counts.iter().filter(|(_, count)| **count == most).map(|(pair, _)| (merged(*pair), *pair)).min()?;
    Some((best.1, best.0))
}

/// Replaces every pair in a spelled word by its piece, from the left.
fn merge(spelled: &mut Vec<usize>, pair: (usize, usize), id: usize) {
    let mut at = 0;
    while at + 1 < spelled.len() {
        if (spelled[at], spelled[at + 1]) == pair {
            spelled[at] = id;
            spelled.remove(at + 1);
        }
        at += 1;
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const CAPTIONS: [&str; 4] = [
        "A person waves with the right hand.",
        "a person waves with the left hand twice",
        "The person walks forward, then turns left",
        "someone is walking slowly",
    ];

    #[test]
    fn merges_are_those_of_the_hand_worked_example() {
        // Counts: "aa" 3 x, "ab" 2 x: pairs (a, ##a) 3, (a, ##b) 2.
        let pieces = WordPieces::learn(["aa aa ab", "aa ab"], 76).unwrap();
        assert_eq!(pieces.pieces()[74..], ["aa", "ab"]);
        // Two special pieces, 36 characters, 36 inside of words: digits, then letters.
        assert_eq!(pieces.encode("aab").unwrap(), [74, 2 + 36 + 11]);
    }

    #[test]
    fn order_of_captions_and_a_file_in_between_change_nothing() {
        let pieces = WordPieces::learn(CAPTIONS, 120).unwrap();
        let mut turned = CAPTIONS;
        turned.reverse();
        assert_eq!(WordPieces::learn(turned, 120).unwrap(), pieces);
        let text = serde_json::to_string(&pieces).unwrap();
        assert_eq!(serde_json::from_str::<WordPieces>(&text).unwrap(), pieces);
        for caption in CAPTIONS {
            let ids = pieces.encode(caption).unwrap();
            assert_eq!(pieces.text(&ids), prompt::words(caption).join(" "));
        }
    }

    #[test]
    fn unknown_words_are_spelled_and_unknown_characters_said_to_be_so() {
        let pieces = WordPieces::learn(CAPTIONS, 200).unwrap();
        let ids = pieces.encode("somersault").unwrap();
        assert!(ids.len() > 1 && !ids.contains(&UNKNOWN));
        assert_eq!(pieces.text(&ids), "somersault");
        assert_eq!(pieces.encode("a 走").unwrap(), [2 + 10, UNKNOWN]);
        assert_eq!(pieces.encode(&"a ".repeat(100)).unwrap().len(), MAX_TOKENS);
    }

    #[test]
    fn bad_vocabularies_are_refused() {
        assert!(WordPieces::learn(CAPTIONS, 20).unwrap_err().to_string().contains("at least 74, got 20"));
        let told = |text: &str| serde_json::from_str::<WordPieces>(text).unwrap_err().to_string();
        assert!(told(r#"["a"]"#).contains("first word pieces: expected [pad], [unknown], got a"));
        assert!(told(r#"["[pad]", "[unknown]", "a", "a"]"#).contains("different word pieces: expected 4, got 3"));
    }
}
