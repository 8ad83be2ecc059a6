//! A file of prompts, one per line.

use std::path::Path;

use lifelike_generation::text::prompt;

use crate::error::CliError;

/// Most letters of a prompt in the name of its file.
const LETTERS: usize = 40;

/// Returns the prompts of a file. Empty lines and those that begin with `#` are none.
///
/// # Errors
/// A file that cannot be read or holds none, or the first line that is no prompt, by its number.
pub fn read(path: &Path) -> Result<Vec<String>, CliError> {
    let text = std::fs::read_to_string(path).map_err(|e| CliError::Input(format!("{}: {e}", path.display())))?;
    let mut prompts = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let at = |e| CliError::Input(format!("{}:{}: {e}", path.display(), number + 1));
        prompts.push(prompt::check(line).map_err(at)?.to_string());
    }
    if prompts.is_empty() {
        return Err(CliError::Input(format!("{}: expected a prompt per line, got none", path.display())));
    }
    Ok(prompts)
}

/// Returns a name for the motion of the prompt with this number, from 1: sorted by name they keep their order.
pub fn name(number: usize, prompt: &str) -> String {
    format!("{number:03}-{}", slug(prompt))
}

/// Returns a prompt as a part of a file's name: its words, joined by dashes.
pub fn slug(prompt: &str) -> String {
    let words = prompt::words(prompt).join("-");
    let short: String = words.chars().take(LETTERS).collect();
    short.trim_end_matches('-').to_string()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn lines_are_prompts_and_a_bad_one_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("p.txt");
        let of = |text: &str| {
            std::fs::write(&file, text).unwrap();
            read(&file).map_err(|e| e.to_string())
        };
        assert_eq!(of("# two\n a person waves \n\nA man walks.\n").unwrap(), ["a person waves", "A man walks."]);
        assert!(of("walk\n走る\n").unwrap_err().contains("p.txt:2: prompt"));
        assert!(of("\n").unwrap_err().contains("got none"));
        assert_eq!(name(7, "A person waves: left hand!"), "007-a-person-waves-left-hand");
    }
}
