//! A script as a text that a person edits.

use std::path::Path;

use super::Script;
use crate::error::LanguageError;
use crate::grammar::Grammar;

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
    /// [`LanguageError::Io`] for a file that cannot be read; [`LanguageError::Line`] for one that is no script, has verbs that
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
        match script.clauses.iter().find(|clause| !(1..=2).contains(&clause.actions.len())) {
            Some(clause) => {
                let message = format!("expected one action or two in a clause, got {}", clause.actions.len());
                Err(LanguageError::line(path, 1, message))
            }
            None if script.clauses.is_empty() => Err(LanguageError::line(path, 1, "expected a clause, got none")),
            None => Ok(script),
        }
    }
}
