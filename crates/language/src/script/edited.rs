//! A script as a text that a person edits.

use std::path::Path;

use super::Script;
use super::limbs::is_above;
use super::said::MAX_COUNT;
use crate::facts::Action;
use crate::grammar::{Grammar, Verb};
use crate::posture::Posture;
use crate::{FromInput, LanguageError};

/// Most repetitions of a clause.
const MAX_TIMES: u32 = 1000;

impl Script {
    /// Returns the script as TOML.
    ///
    /// # Errors
    /// [`LanguageError::Grammar`] for numbers that TOML has not.
    pub fn to_toml(&self) -> Result<String, LanguageError> {
        let head = "# What was understood, one clause after the other. Change it, and generate with --script FILE.\n";
        let text = toml::to_string(self).map_err(|e| LanguageError::Grammar(e.to_string()))?;
        Ok(format!("{head}{text}"))
    }

    /// Reads a script.
    ///
    /// # Errors
    /// [`LanguageError::Input`] for a file that cannot be read; [`LanguageError::Line`] for one that is no script, has verbs that
    /// the grammar has not, or no clause.
    pub fn read(path: &Path, grammar: &Grammar) -> Result<Self, LanguageError> {
        let text = std::fs::read_to_string(path).map_err(LanguageError::io(path))?;
        let line_at = |at: usize| text[..at.min(text.len())].matches('\n').count() + 1;
        let script: Self = toml::from_str(&text).map_err(|error| {
            let line = error.span().map_or(1, |span| line_at(span.start));
            LanguageError::line(path, line, error.message().to_string())
        })?;
        for action in script.clauses.iter().flat_map(|clause| &clause.actions) {
            let place = text.find(&format!("\"{}\"", action.verb)).map_or(1, line_at);
            grammar.verb(&action.verb).map_err(|error| LanguageError::line(path, place, error.to_string()))?;
        }
        script.check(grammar).map_err(|message| LanguageError::line(path, 1, message))?;
        Ok(script)
    }

    /// Checks numbers and pairs, which a sentence cannot have wrong.
    pub(crate) fn check(&self, grammar: &Grammar) -> Result<(), String> {
        if self.clauses.is_empty() {
            return Err("expected a clause, got none".into());
        }
        for (at, clause) in self.clauses.iter().enumerate() {
            let fail = |expected: &str, got: String| Err(format!("clause {}: expected {expected}, got {got}", at + 1));
            if clause.seconds.is_some_and(|seconds| !(seconds > 0.0 && seconds.is_finite())) {
                let got = clause.seconds.unwrap_or_default().to_string();
                return fail("seconds above 0", got);
            }
            if !(1..=MAX_TIMES).contains(&clause.times) {
                return fail(&format!("times from 1 to {MAX_TIMES}"), clause.times.to_string());
            }
            let is_low = clause.actions.iter().all(|one| grammar.verb(&one.verb).is_ok_and(Verb::is_low_pose));
            let is_held = (clause.postures.len() == 1 || is_low) && clause.postures.iter().all(Posture::leaves_feet);
            if !(clause.postures.is_empty() || clause.is_only_postures() || is_held && clause.actions.len() == 1) {
                return fail(
                    "'stand' beside postures, or one posture that moves no foot (several during kneeling and its kin)",
                    format!("{} postures", clause.postures.len()),
                );
            }
            for posture in &clause.postures {
                posture.check().map_err(|error| format!("clause {}: {error}", at + 1))?;
            }
            for action in &clause.actions {
                let verb = &action.verb;
                if let Some(count) = action.count.filter(|count| !(1..=MAX_COUNT as u32).contains(count)) {
                    return fail(&format!("count of '{verb}' from 1 to {MAX_COUNT}"), count.to_string());
                }
                if let Some(metres) = action.metres.filter(|metres| !(*metres > 0.0 && metres.is_finite())) {
                    return fail(&format!("metres of '{verb}' above 0"), metres.to_string());
                }
            }
            let verb = |action: &Action| grammar.verb(&action.verb).map_err(|error| error.to_string());
            match clause.actions.as_slice() {
                [_] => {}
                [a, b] => {
                    let pair = ((verb(a)?, a), (verb(b)?, b));
                    if !is_above(pair.0, pair.1) && !is_above(pair.1, pair.0) {
                        return fail("two actions of different limbs", format!("'{}' and '{}'", a.verb, b.verb));
                    }
                }
                others => return fail("one action or two", others.len().to_string()),
            }
        }
        Ok(())
    }
}
