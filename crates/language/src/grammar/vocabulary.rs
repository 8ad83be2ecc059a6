//! The grammar's words: those that are trained on, and those that are held out.

use std::collections::BTreeSet;

use super::table::Grammar;
use super::words::{FIXED, Form, inflected};
use crate::error::LanguageError;

impl Grammar {
    /// Returns every word of the captions that are trained on, in every form, in small letters.
    pub fn trained_words(&self) -> BTreeSet<String> {
        let common = [&self.subjects, &self.imperative, &self.then, &self.during];
        let phrases = self.verbs.iter().map(|verb| &verb.say);
        let mut all: BTreeSet<String> = common
            .into_iter()
            .chain(self.adverbs.values())
            .chain(phrases)
            .flatten()
            .flat_map(|t| words_of(t))
            .collect();
        all.extend(words_of(FIXED));
        all
    }

    /// Returns the words that no caption is trained on and captions of [`crate::facts::HeldOut::Words`] are made of.
    pub fn held_out_words(&self) -> BTreeSet<String> {
        let common = [&self.new_subjects, &self.new_imperative, &self.new_then, &self.new_during];
        let phrases = self.verbs.iter().map(|verb| &verb.new);
        let all = common.into_iter().chain(self.new_adverbs.values()).chain(phrases).flatten();
        let trained = self.trained_words();
        all.flat_map(|text| words_of(text)).filter(|word| !trained.contains(word)).collect()
    }

    /// Checks that every held-out verb phrase has a word that is never trained on, in any form.
    pub(super) fn holds_words_out(&self) -> Result<(), LanguageError> {
        let trained = self.trained_words();
        for verb in &self.verbs {
            if let Some(phrase) = verb.new.iter().find(|phrase| words_of(phrase).is_subset(&trained)) {
                return Err(LanguageError::Grammar(format!(
                    "verb '{}': expected a word in '{phrase}' that stands in no phrase of `say`, got trained ones only",
                    verb.name
                )));
            }
        }
        Ok(())
    }
}

/// Returns the words of a caption or of a grammar's template, those in brackets in every form; slots are none.
pub fn words_of(template: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for form in Form::ALL {
        let mut in_slot = false;
        let text: String = inflected(template, form)
            .chars()
            .map(|c| {
                in_slot = c == '{' || (in_slot && c != '}');
                if in_slot || !c.is_alphabetic() { ' ' } else { c }
            })
            .collect();
        found.extend(text.split_whitespace().map(str::to_lowercase));
    }
    found
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::dataset::Split;
    use crate::facts::HeldOut;
    use crate::grammar::draw::draw;
    use crate::grammar::words::captions;
    use lifelike_checkpoint::rng::stream;

    #[test]
    fn templates_have_words_in_every_form_and_slots_have_none() {
        let expected = ["a", "nod", "nodding", "nods", "times", "two"];
        assert_eq!(words_of("a [nod] {hand}, TWO times").into_iter().collect::<Vec<_>>(), expected);
    }

    /// Words that are drawn, not those of the grammar's text: words that the code writes count too.
    #[test]
    fn held_out_words_stand_in_no_caption_but_held_out_ones() {
        let grammar = Grammar::builtin().unwrap();
        let usable: Vec<usize> = (0..grammar.verbs.len()).collect();
        let reserved = grammar.held_out_words();
        let (mut known, mut new) = (BTreeSet::new(), BTreeSet::new());
        let mut sentences = 0;
        for index in 0..24_000 {
            let drawn = draw(&grammar, &usable, 9, index).unwrap();
            let held_out = drawn.facts.held_out == Some(HeldOut::Words);
            assert!(!held_out || drawn.split == Split::HeldOut);
            let mut rng = stream(9, "words", index, 0);
            for text in captions(&grammar, &drawn.facts, held_out, 5, &mut rng).unwrap() {
                let words = words_of(&text);
                if held_out {
                    assert!(words.iter().any(|word| reserved.contains(word)), "{text}");
                    sentences += 1;
                    new.extend(words);
                } else {
                    known.extend(words);
                }
            }
        }
        let trained = grammar.trained_words();
        let unknown: Vec<&String> = known.difference(&trained).collect();
        assert!(unknown.is_empty(), "{unknown:?}");
        let only_held_out: BTreeSet<String> = new.difference(&trained).cloned().collect();
        assert!(sentences > 500, "{sentences}");
        assert!(only_held_out.is_subset(&reserved) && only_held_out.len() >= 100);
        for word in ["hastily", "unhurriedly", "humanoid", "hurdle", "summons", "polishes", "pivots", "halts"] {
            assert!(only_held_out.contains(word), "{word}");
        }
    }
}
