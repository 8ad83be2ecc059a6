//! Scripts by another program: a language model that reads the brief and a sentence, and answers with a script.

use std::io::Write;
use std::process::{Command, Stdio};

use lifelike_language::script::{Reader, Script};

use crate::error::CliError;

/// Times that a program is asked for a sentence: the second time with what was wrong.
const TIMES: usize = 2;
/// Most letters of an answer in a message.
const SHOWN: usize = 200;

/// Returns a command that the system's shell runs.
fn shell(command: &str) -> Command {
    let (program, option) = if cfg!(windows) { ("cmd", "/C") } else { ("sh", "-c") };
    let mut shell = Command::new(program);
    shell.arg(option).arg(command);
    shell
}

/// Asks a program for the script of a sentence: it reads the brief and the sentence, and writes the script.
///
/// # Errors
/// A program that cannot be run or fails, or that answers twice with something else than a script.
pub fn script(reader: &Reader<'_>, command: &str, sentence: &str) -> Result<Script, CliError> {
    let brief = reader.grammar().brief();
    let mut question = format!("{brief}\n# The sentence\n\n{sentence}\n");
    let mut last = String::new();
    for _ in 0..TIMES {
        let answer = answered(command, &question)?;
        match reader.reply(&answer) {
            Ok(script) => return Ok(script),
            Err(error) => {
                let shown: String = answer.trim().chars().take(SHOWN).collect();
                last = format!("--reader '{command}': \"{sentence}\": {error}; it answered '{shown}'");
                question += &format!("\nYou answered:\n{answer}\nThat is not a script: {error}. Answer again.\n");
            }
        }
    }
    Err(CliError::Input(last))
}

/// Returns what a command writes for a question on its standard input.
fn answered(command: &str, question: &str) -> Result<String, CliError> {
    let failed = |what: &dyn std::fmt::Display| CliError::Input(format!("--reader '{command}': {what}"));
    let mut child = shell(command)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|e| failed(&e))?;
    let input = child.stdin.take();
    let question = question.to_owned();
    // A program may begin to answer before it has read everything, or read nothing at all.
    let writer = std::thread::spawn(move || input.map(|mut input| input.write_all(question.as_bytes())));
    let output = child.wait_with_output().map_err(|e| failed(&e))?;
    let _ = writer.join();
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(failed(&format!("{}: {}", output.status, said.trim())));
    }
    String::from_utf8(output.stdout).map_err(|e| failed(&e))
}

#[cfg(all(test, unix))]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_language::grammar::Grammar;

    use super::*;

    #[test]
    fn a_program_answers_with_a_script() {
        let grammar = Grammar::builtin().unwrap();
        let reader = Reader::new(&grammar).unwrap();
        let say = r#"echo '{"clause": [{"action": [{"verb": "bow", "count": 2}]}]}'"#;
        assert_eq!(script(&reader, say, "bow twice").unwrap().to_string(), "bow, 2 times");
        // It reads the brief and the sentence, and once more what was wrong.
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("asked.txt");
        let bad = format!("cat >> {}; echo nothing", file.display());
        let error = script(&reader, &bad, "bow twice").unwrap_err().to_string();
        assert!(
            error.contains("\"bow twice\"") && error.contains("got none") && error.contains("'nothing'"),
            "{error}"
        );
        let asked = std::fs::read_to_string(file).unwrap();
        assert_eq!(asked.matches("# The sentence\n\nbow twice").count(), 2);
        assert_eq!(asked.matches("Answer again").count(), 1);
        assert!(asked.contains("walk_backward: feet"));
        let error = script(&reader, "echo broken >&2; exit 7", "bow").unwrap_err().to_string();
        assert!(error.contains("broken") && error.contains('7'), "{error}");
    }
}
