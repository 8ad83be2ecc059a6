//! Text for people, JSON for scripts.

use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;
use std::sync::OnceLock;

use lifelike_report::{Cell, Column, Screen, Table};
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

/// Longest line of a message (characters): TOML's errors quote the line of the file.
const LONGEST_LINE: usize = 10_000;
/// The standard library's words for a binary file where text is read.
const BINARY: &str = "stream did not contain valid UTF-8";

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
            eprintln!("{}", serde_json::json!({ "error": readable(&error.to_string()), "code": error.code() }));
        } else {
            eprintln!("lifelike: {}", readable(&error.to_string()));
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

/// Writes a file of a result, whole or not at all; a symbolic link or a pipe at its place is refused.
///
/// # Errors
/// [`CliError::Failed`] with the file and the reason; [`CliError::Input`] where the place is taken.
pub fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), CliError> {
    lifelike_checkpoint::write_file(path, content.as_ref()).map_err(CliError::write(path))
}

/// Writes a result as JSON, as [`write()`] writes a text.
///
/// # Errors
/// As [`write()`]; [`CliError::Failed`] for what is no JSON.
pub fn write_json(path: &Path, value: &(impl Serialize + ?Sized)) -> Result<(), CliError> {
    let text = serde_json::to_string_pretty(value).map_err(|e| CliError::Failed(e.to_string()))?;
    write(path, text)
}

/// True where the command line asks for all columns.
static WIDE: OnceLock<bool> = OnceLock::new();

/// Shows all columns of tables from now on, however long their lines become.
pub(crate) fn show_all_columns(wide: bool) {
    let _ = WIDE.set(wide);
}

/// Returns whether people see everything.
pub(crate) fn shows_all_columns() -> bool {
    WIDE.get().copied().unwrap_or(false)
}

/// Space for tables: that of the terminal, or what the variable COLUMNS says.
pub fn screen() -> Screen {
    let variable = std::env::var("COLUMNS").ok().and_then(|text| text.parse().ok()).filter(|n| *n > 0);
    let terminal = || terminal_size::terminal_size_of(std::io::stdout()).map(|(width, _)| usize::from(width.0));
    let columns = variable.or_else(terminal).unwrap_or(Screen::PIPED);
    Screen { columns, wide: shows_all_columns(), colours: colours(&std::io::stdout()) }
}

/// Returns whether colours may be written to a stream: a terminal that knows them, and nobody who set NO_COLOR (no-color.org).
pub fn colours(stream: &impl IsTerminal) -> bool {
    let is_set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    stream.is_terminal() && !is_set("NO_COLOR") && std::env::var_os("TERM").is_none_or(|term| term != "dumb")
}

/// Returns a table as text that fits the terminal.
pub fn fitted(table: &Table) -> String {
    table.to_terminal(screen())
}

/// A table of text that fits the terminal: columns of numbers on the right side, others on the left.
pub fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let is_number =
        |text: &String| text.is_empty() || text.starts_with(|c: char| c.is_ascii_digit() || "-+–".contains(c));
    let column = |(i, name): (usize, &&str)| {
        let numbers = i > 0 && rows.iter().filter_map(|row| row.get(i)).all(is_number);
        if numbers { Column::number(name, "") } else { Column::text(name) }
    };
    let mut table = Table::new("", head.iter().enumerate().map(column).collect());
    table.rows = rows.iter().map(|row| row.iter().map(Cell::text).collect()).collect();
    fitted(&table)
}

/// Returns a message without the lines of a file that are no lines of a person's text.
fn readable(message: &str) -> String {
    let message = message.replace(BINARY, "expected text in UTF-8, got another kind of file");
    let cut = |line: &str| match line.char_indices().nth(LONGEST_LINE) {
        Some((at, _)) => format!("{} ...", &line[..at]),
        None => line.to_owned(),
    };
    message.lines().map(cut).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let rows = vec![vec!["walk".into(), "1.5".into(), "a b".into()], vec!["é".into(), "10.25".into(), "c".into()]];
        let expected = "clip  error  why\n────  ─────  ───\nwalk    1.5  a b\né     10.25  c\n";
        assert_eq!(table(&["clip", "error", "why"], &rows), expected);
    }

    #[test]
    fn a_message_does_not_carry_a_file() {
        assert_eq!(readable(&format!("a:\n{}\nb", "x".repeat(200_000))).len(), LONGEST_LINE + 9);
        assert_eq!(
            readable("é: stream did not contain valid UTF-8"),
            "é: expected text in UTF-8, got another kind of file"
        );
    }
}
