//! Next steps as commands that work when they are pasted into a shell.

use std::fmt::Display;
use std::path::Path;

use lifelike_robot::load::{FETCHED, NAMES};

/// Clips that a printed command names at most.
pub const MAX_CLIPS: usize = 3;

/// A command line that grows word by word, each quoted as a shell needs it.
#[derive(Debug, Clone)]
pub struct NextCommand(String);

impl NextCommand {
    /// Begins with the words of a subcommand (`train tracker`).
    pub fn new(subcommand: &str) -> Self {
        Self(format!("lifelike {subcommand}"))
    }

    /// Adds a word.
    #[must_use]
    pub fn word(self, word: impl Display) -> Self {
        Self(format!("{} {}", self.0, quoted(&word.to_string())))
    }

    /// Adds an option and its path.
    #[must_use]
    pub fn path(self, option: &str, path: &Path) -> Self {
        self.word(option).word(path.display())
    }

    /// Adds `--robot` where a policy's file would not lead to the robot by itself: for all but built-in ones.
    #[must_use]
    pub fn robot(self, robot: &str) -> Self {
        if NAMES.contains(&robot) { self } else { self.word("--robot").word(robot) }
    }

    /// Adds `--motions` and the first few of these clips; our own where there are none.
    #[must_use]
    pub fn motions<T: AsRef<Path>>(self, clips: &[T]) -> Self {
        let start = self.word("--motions");
        if clips.is_empty() {
            return start.word("builtin");
        }
        clips.iter().take(MAX_CLIPS).fold(start, |line, clip| line.word(clip.as_ref().display()))
    }
}

/// Returns whether a robot is known by name, wherever a command runs.
pub fn is_known(robot: &str) -> bool {
    NAMES.contains(&robot) || FETCHED.iter().any(|(name, _)| *name == robot)
}

/// Returns the commands as lines for people, under a heading; nothing where there are none.
pub fn lines(commands: &[NextCommand]) -> String {
    let lines: String = commands.iter().map(|command| format!("  {command}\n")).collect();
    if lines.is_empty() { lines } else { format!("next:\n{lines}") }
}

/// Returns the commands for scripts.
pub fn texts(commands: &[NextCommand]) -> Vec<String> {
    commands.iter().map(NextCommand::to_string).collect()
}

impl Display for NextCommand {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

/// Returns a word as a POSIX shell reads it back.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./:=@,+%".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_reads_every_word_back() {
        for (word, text) in [
            ("runs/a-1/x.safetensors", "runs/a-1/x.safetensors"),
            ("my robots/a b.xml", "'my robots/a b.xml'"),
            ("data/*.bvh", "'data/*.bvh'"),
            ("it's", r"'it'\''s'"),
            ("", "''"),
            ("clips=[\"a\"]", "'clips=[\"a\"]'"),
        ] {
            assert_eq!(quoted(word), text);
        }
    }

    #[test]
    fn a_robot_is_named_where_its_name_would_not_find_it() {
        let eval = |robot| NextCommand::new("eval").robot(robot).motions::<&str>(&[]).to_string();
        assert_eq!(eval("lima"), "lifelike eval --motions builtin");
        assert_eq!(eval("my robots/a.xml"), "lifelike eval --robot 'my robots/a.xml' --motions builtin");
    }
}
