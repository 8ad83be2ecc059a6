//! Sentences with their actions marked: `okay, {wave|say hello} and {bow|bend low}`.

use std::ops::Range;

use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::script::split::normal;

/// Words of a sentence, and which of them ask for which action.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Sentence {
    pub words: Vec<String>,
    /// Words and label of each action, in the order of the text.
    pub spans: Vec<(Range<usize>, usize)>,
}

/// Joins between sentences that are put together.
const JOINS: [&str; 20] = [
    "and",
    "and",
    "then",
    ", then",
    "and then",
    "|",
    "|",
    "|",
    "after that",
    "| then",
    "| next",
    "followed by",
    "before you",
    "while",
    "while you",
    "as you",
    "and at the same time",
    ", and",
    "and finally",
    ",",
];

impl Sentence {
    /// Reads a marked sentence; one without words where a rule of [`normal`] rewrites a mark. `label` gives the number of a name.
    ///
    /// # Errors
    /// A brace that does not close, or a name without a number.
    pub fn read(text: &str, label: impl Fn(&str) -> Option<usize>) -> Result<Self, String> {
        // Braces become words, so that the text around them is divided as ever.
        let mut plain = String::new();
        let mut labels = Vec::new();
        let mut rest = text;
        while let Some((before, after)) = rest.split_once('{') {
            let (inside, after) = after.split_once('}').ok_or_else(|| format!("'{text}': a brace is not closed"))?;
            let (name, words) = inside.split_once('|').ok_or_else(|| format!("'{text}': expected {{name|words}}"))?;
            if words.contains('{') {
                return Err(format!("'{text}': nested braces"));
            }
            labels.push(label(name.trim()).ok_or_else(|| format!("'{text}': no action '{name}'"))?);
            plain += &format!("{before} {OPEN} {words} {CLOSE} ");
            rest = after;
        }
        plain += rest;
        let mut own = Self::default();
        let mut start = None;
        let mut labels = labels.into_iter();
        for word in normal(&plain) {
            match word.as_str() {
                OPEN => start = Some(own.words.len()),
                CLOSE => {
                    let from = start.take().unwrap_or(own.words.len());
                    // A rule that rewrites a mark takes the sentence away.
                    let Some(label) = labels.next() else { return Ok(Self::default()) };
                    let last = own.words[from..].iter().rposition(|word| word != "|" && word != ",");
                    if let Some(last) = last {
                        own.spans.push((from..from + last + 1, label));
                    }
                }
                _ => own.words.push(word),
            }
        }
        Ok(if labels.next().is_some() || start.is_some() { Self::default() } else { own })
    }

    /// Returns the class of each word: 0 outside of actions, 1 where one begins, 2 within.
    pub fn tags(&self) -> Vec<usize> {
        let mut out = vec![0; self.words.len()];
        for (range, _) in &self.spans {
            out[range.clone()].fill(2);
            out[range.start] = 1;
        }
        out
    }

    /// Puts another sentence after this one, which a word at its front makes a part of the same: "before you wave, bow".
    pub fn lead(&mut self, other: &Self, rng: &mut ChaCha8Rng) {
        let front: Vec<&str> = FRONTS[rng.random_range(0..FRONTS.len())].split(' ').collect();
        self.spans.iter_mut().for_each(|(range, _)| *range = range.start + front.len()..range.end + front.len());
        self.words.splice(0..0, front.into_iter().map(str::to_string));
        self.append(",", other);
    }

    /// Appends another sentence behind a join.
    pub fn join(&mut self, other: &Self, rng: &mut ChaCha8Rng) {
        self.append(JOINS[rng.random_range(0..JOINS.len())], other);
    }

    fn append(&mut self, join: &str, other: &Self) {
        self.words.extend(join.split(' ').map(str::to_string));
        let from = self.words.len();
        self.words.extend(other.words.iter().cloned());
        self.spans.extend(other.spans.iter().map(|(range, label)| (range.start + from..range.end + from, *label)));
    }
}

/// Fronts of sentences that others follow.
const FRONTS: [&str; 8] = ["before you", "before", "after you", "after", "once you", "while you", "while", "as you"];
const OPEN: &str = "zqopen";
const CLOSE: &str = "zqclose";

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn braces_mark_the_words_of_actions() {
        let label = |name: &str| ["wave", "bow"].iter().position(|known| *known == name);
        let read = Sentence::read("Okay, {wave|say hello twice!} and {bow|bend low}.", label).unwrap();
        assert_eq!(read.words.join(" "), "okay , say hello twice | and bend low |");
        assert_eq!(read.spans, [(2..5, 0), (7..9, 1)]);
        assert_eq!(read.tags(), [0, 0, 1, 2, 2, 0, 0, 1, 2, 0]);
        assert!(Sentence::read("{wave|hello", label).unwrap_err().contains("not closed"));
        assert!(Sentence::read("{fly|up}", label).unwrap_err().contains("no action 'fly'"));
    }
}
