//! The check of a prompt before anything reads it, and its words.

use crate::GenerationError;

/// Most characters of a prompt.
pub const MAX_CHARACTERS: usize = 300;

/// Returns the prompt without surrounding white space.
///
/// # Errors
/// [`GenerationError::Prompt`] for an empty text, one of more than [`MAX_CHARACTERS`] characters, one with control
/// characters, and one without a single Latin letter.
///
/// ```
/// use lifelike_generation::text::prompt::check;
///
/// assert_eq!(check("  A person waves. ")?, "A person waves.");
/// assert!(check("wave\u{7}").is_err());
/// # Ok::<(), lifelike_generation::GenerationError>(())
/// ```
pub fn check(text: &str) -> Result<&str, GenerationError> {
    let text = text.trim();
    if text.is_empty() {
        return Err(GenerationError::prompt("a sentence such as \"a person waves\"", "an empty text"));
    }
    let count = text.chars().count();
    if count > MAX_CHARACTERS {
        return Err(GenerationError::prompt(
            format!("at most {MAX_CHARACTERS} characters"),
            format!("{count}; describe one motion, and continue with further prompts"),
        ));
    }
    if let Some((at, c)) = text.chars().enumerate().find(|(_, c)| c.is_control()) {
        return Err(GenerationError::prompt(
            "one line of plain text",
            format!("control character U+{:04X} at character {}", u32::from(c), at + 1),
        ));
    }
    if !text.chars().any(|c| c.is_ascii_alphabetic()) {
        return Err(GenerationError::prompt("an English sentence", format!("\"{text}\", without a Latin letter")));
    }
    Ok(text)
}

/// Returns the lower-case words of a text: runs of letters and digits; everything else separates them.
pub fn words(text: &str) -> Vec<String> {
    let lower = text.to_lowercase();
    lower.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn what_is_no_sentence_is_refused_in_plain_words() {
        let told = |text: &str| check(text).unwrap_err().to_string();
        assert!(told(" \t\n").contains("got an empty text"));
        assert!(told(&"walk ".repeat(61)).contains("at most 300 characters, got 304"), "{}", told(&"walk ".repeat(61)));
        assert!(told("walk\nfast").contains("control character U+000A at character 5"));
        assert!(told("走る").contains("without a Latin letter"));
        assert!(told("3 1 4").contains("without a Latin letter"));
        assert_eq!(check(&"x".repeat(MAX_CHARACTERS)).unwrap().len(), MAX_CHARACTERS);
    }

    #[test]
    fn words_are_lower_case_runs_of_letters_and_digits() {
        assert_eq!(words("A person's LEFT-hand, 2x."), ["a", "person", "s", "left", "hand", "2x"]);
        assert!(words(" ,.!").is_empty());
    }
}
