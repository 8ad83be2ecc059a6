//! Text for people, JSON for scripts.

use std::io::{ErrorKind, Write};

use serde::Serialize;

use crate::error::CliError;

/// Destination and form of results.
#[derive(Debug, Clone, Copy)]
pub struct Output {
    /// JSON instead of text.
    pub json: bool,
    /// No progress.
    pub quiet: bool,
    /// No results: the command is a part of another one.
    pub silent: bool,
}

impl Output {
    /// Prints a result: `value` as JSON, or `text` for people.
    pub fn result<T: Serialize>(&self, value: &T, text: impl FnOnce() -> String) -> Result<(), CliError> {
        if self.silent {
            Ok(())
        } else if self.json {
            let json = serde_json::to_string_pretty(value).map_err(|e| CliError::Failed(e.to_string()))?;
            print(&json)
        } else {
            print(text().trim_end())
        }
    }

    /// Prints an error on standard error: as JSON where results are JSON.
    pub fn error(&self, error: &CliError) {
        if self.json {
            eprintln!("{}", serde_json::json!({ "error": error.to_string(), "code": error.code() }));
        } else {
            eprintln!("lifelike: {error}");
        }
    }

    /// Returns whether progress may be drawn.
    pub fn shows_progress(&self) -> bool {
        !self.json && !self.quiet
    }
}

/// Prints to standard output. A reader that has seen enough (`| head`) is no failure.
fn print(text: &str) -> Result<(), CliError> {
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(CliError::Failed(format!("standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// A table of text: the first column left, the others right, as wide as they need.
pub fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|r| r.get(column)).map(|c| c.chars().count());
        cells.chain(head.get(column).map(|h| h.chars().count())).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..head.len()).map(width).collect();
    let line = |cells: &[String]| {
        let padded = cells.iter().zip(&widths).enumerate().map(|(i, (cell, width))| {
            let space = " ".repeat(width.saturating_sub(cell.chars().count()));
            if i == 0 { format!("{cell}{space}") } else { format!("{space}{cell}") }
        });
        padded.collect::<Vec<_>>().join("  ").trim_end().to_string() + "\n"
    };
    let head: Vec<String> = head.iter().map(|h| (*h).to_string()).collect();
    let rule: Vec<String> = widths.iter().map(|w| "-".repeat(*w)).collect();
    let mut text = line(&head) + &line(&rule);
    rows.iter().for_each(|row| text.push_str(&line(row)));
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let rows = vec![vec!["walk".to_string(), "1.5".to_string()], vec!["é".to_string(), "10.25".to_string()]];
        let expected = "clip  error\n----  -----\nwalk    1.5\né     10.25\n";
        assert_eq!(table(&["clip", "error"], &rows), expected);
    }
}
