//! Reactions to what happens around somebody, where a sentence names no action.

use std::collections::BTreeSet;

use serde::Deserialize;

use super::phrases::Phrases;
use crate::error::LanguageError;

const TEXT: &str = include_str!("situations.toml");
/// Words of a situation that is clear by itself.
const CLEAR: usize = 3;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    sees: Vec<String>,
    means: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    situation: Vec<Entry>,
}

/// A reaction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reaction<'a> {
    /// The sentence to perform.
    pub means: &'a str,
    /// True where the words tell the situation from an action.
    pub is_clear: bool,
}

/// Situations by their words.
#[derive(Debug)]
pub(super) struct Situations(Vec<(BTreeSet<String>, String)>);

impl Situations {
    /// Reads the table that comes with the crate.
    pub fn new(phrases: &Phrases) -> Result<Self, LanguageError> {
        let table: Table = toml::from_str(TEXT).map_err(|e| LanguageError::Grammar(format!("situations: {e}")))?;
        let base = |word: &str| phrases.base(word);
        let all = table.situation.into_iter().flat_map(|entry| {
            let means = entry.means;
            entry.sees.into_iter().map(move |words| (words, means.clone()))
        });
        Ok(Self(all.map(|(words, means)| (words.split_whitespace().map(base).collect(), means)).collect()))
    }

    /// Returns the reaction to a sentence: that of the situation with the most words of those that are all in it.
    pub fn reaction(&self, phrases: &Phrases, words: &[String]) -> Option<Reaction<'_>> {
        let bases: BTreeSet<String> = words.iter().map(|word| phrases.base(word)).collect();
        let seen = self.0.iter().filter(|(sees, _)| sees.is_subset(&bases));
        // Of equal ones the first.
        let best = seen.reduce(|best, next| if next.0.len() > best.0.len() { next } else { best })?;
        Some(Reaction { means: &best.1, is_clear: best.0.len() >= CLEAR })
    }

    /// Returns the sentences of all reactions.
    #[cfg(test)]
    pub fn reactions(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|(_, means)| means.as_str())
    }
}
