//! Scripts by another program: a language model that reads the brief and a sentence, and answers with a script.

use std::fmt::Display;
use std::io::Write;
use std::process::{Command, Stdio};

use lifelike_character::Anatomy;

use super::{Reader, Script};
use crate::error::LanguageError;

/// Variable that names the command by which sentences are read.
const READER: &str = "LIFELIKE_READER";
/// Times that a program is asked for a sentence: the second time with what was wrong.
const TIMES: usize = 2;
/// Most letters of an answer in a message.
const SHOWN: usize = 200;

/// A command that reads sentences in the place of the program's own reader.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Asked {
    command: String,
}

impl Asked {
    /// Returns the command of a name, or that of the variable `LIFELIKE_READER`.
    pub fn new(command: Option<&str>) -> Option<Self> {
        let command = command.map(str::to_owned).or_else(|| std::env::var(READER).ok());
        command.filter(|command| !command.is_empty()).map(|command| Self { command })
    }

    /// Asks for the script of a sentence: the program reads the brief and the sentence, and writes the script.
    ///
    /// # Errors
    /// [`LanguageError::Reader`] for a program that cannot be run or fails, or that answers twice with something else than a
    /// script.
    pub fn script(&self, reader: &Reader<'_>, anatomy: &Anatomy, sentence: &str) -> Result<Script, LanguageError> {
        self.ask((reader, anatomy), sentence, "")
    }

    /// Asks again for a sentence of which something failed. `did`: what the robot did with the script, in lines.
    ///
    /// # Errors
    /// As [`Self::script`].
    pub fn better(
        &self,
        reader: &Reader<'_>,
        anatomy: &Anatomy,
        sentence: &str,
        (script, did): (&Script, &str),
    ) -> Result<Script, LanguageError> {
        let before = serde_json::to_string(script).map_err(|e| LanguageError::Grammar(e.to_string()))?;
        let more = format!(
            "\nYou answered:\n{before}\n\nThe robot did it, and this was measured:\n{did}\n\
             If another script does better what the sentence says, answer with that script, whole; else with the same one.\n"
        );
        self.ask((reader, anatomy), sentence, &more)
    }

    fn ask(
        &self,
        (reader, anatomy): (&Reader<'_>, &Anatomy),
        sentence: &str,
        more: &str,
    ) -> Result<Script, LanguageError> {
        let brief = reader.grammar().brief(anatomy);
        let mut question = format!("{brief}\n# The sentence\n\n{sentence}\n{more}");
        let mut last = String::new();
        for _ in 0..TIMES {
            let answer = self.answered(&question)?;
            match reader.reply(&answer) {
                Ok(script) => return Ok(script),
                Err(error) => {
                    let shown: String = answer.trim().chars().take(SHOWN).collect();
                    last = format!("\"{sentence}\": {error}; it answered '{shown}'");
                    question += &format!("\nYou answered:\n{answer}\nThat is not a script: {error}. Answer again.\n");
                }
            }
        }
        Err(self.failed(&last))
    }

    fn failed(&self, what: &dyn Display) -> LanguageError {
        LanguageError::Reader { command: self.command.clone(), message: what.to_string() }
    }

    /// Returns what the command writes for a question on its standard input.
    fn answered(&self, question: &str) -> Result<String, LanguageError> {
        let mut child = shell(&self.command)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|e| self.failed(&e))?;
        let input = child.stdin.take();
        let question = question.to_owned();
        // A program may begin to answer before it has read everything, or read nothing at all.
        let writer = std::thread::spawn(move || input.map(|mut input| input.write_all(question.as_bytes())));
        let output = child.wait_with_output().map_err(|e| self.failed(&e))?;
        let _ = writer.join();
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            return Err(self.failed(&format!("{}: {}", output.status, said.trim())));
        }
        String::from_utf8(output.stdout).map_err(|e| self.failed(&e))
    }
}

/// Returns a command that the system's shell runs.
fn shell(command: &str) -> Command {
    let (program, option) = if cfg!(windows) { ("cmd", "/C") } else { ("sh", "-c") };
    let mut shell = Command::new(program);
    shell.arg(option).arg(command);
    shell
}

#[cfg(all(test, unix))]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::fixtures;
    use crate::grammar::Grammar;

    #[test]
    fn a_program_answers_with_a_script() {
        let grammar = Grammar::builtin().unwrap();
        let reader = Reader::new(&grammar).unwrap();
        let (_, anatomy) = fixtures::lima();
        let asked = |command: &str| Asked::new(Some(command)).unwrap();
        let say = r#"echo '{"clause": [{"action": [{"verb": "bow", "count": 2}]}]}'"#;
        let twice = asked(say).script(&reader, &anatomy, "bow twice").unwrap();
        assert_eq!(twice.to_string(), "bow, 2 times");
        // It reads the brief and the sentence, and once more what was wrong.
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("asked.txt");
        let bad = asked(&format!("cat >> {}; echo nothing", file.display()));
        let error = bad.script(&reader, &anatomy, "bow twice").unwrap_err().to_string();
        assert!(
            error.contains("\"bow twice\"") && error.contains("got none") && error.contains("'nothing'"),
            "{error}"
        );
        let text = std::fs::read_to_string(&file).unwrap();
        assert_eq!(text.matches("# The sentence\n\nbow twice").count(), 2);
        assert_eq!(text.matches("Answer again").count(), 1);
        assert!(text.contains("walk_backward: feet"));
        // The script that failed and what was measured stand in the question.
        bad.better(&reader, &anatomy, "bow twice", (&twice, "in physics: falls at 2 s")).unwrap_err();
        let text = std::fs::read_to_string(file).unwrap();
        assert!(text.contains("\"times\":2") && text.contains("falls at 2 s\nIf another script"), "{}", text.len());
        let error = asked("echo broken >&2; exit 7").script(&reader, &anatomy, "bow").unwrap_err().to_string();
        assert!(error.contains("broken") && error.contains('7'), "{error}");
        assert_eq!(Asked::new(Some("")), None);
    }
}
