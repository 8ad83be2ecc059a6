//! Text of unknown origin, line by line: encodings checked once, every complaint with its line.

use std::path::{Path, PathBuf};

use crate::{FromInput, MotionError};

/// No angle, length or count in a capture is larger than this; anything beyond is a broken file.
const LARGEST: f64 = 1e9;

/// Reads a whole file.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, MotionError> {
    std::fs::read(path).map_err(MotionError::io(path))
}

/// Checks the encoding: UTF-8 (of which ASCII is a part) without NUL, a byte-order mark is skipped.
pub(crate) fn decode<'a>(bytes: &'a [u8], file: &Path) -> Result<&'a str, MotionError> {
    let wrong = |line, got: &str| parse_error(file, line, "text in ASCII or UTF-8", got);
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(wrong(1, "UTF-16"));
    }
    let bytes = bytes.strip_prefix(&[0xef, 0xbb, 0xbf]).unwrap_or(bytes);
    let text = std::str::from_utf8(bytes).map_err(|e| {
        if matches!(bytes, [0x1f, 0x8b, ..] | [0x78, 0x01 | 0x5e | 0x9c | 0xda, ..]) {
            return wrong(1, "a compressed file (gzip or zlib): unpack it");
        }
        let before = &bytes[..e.valid_up_to()];
        let byte = bytes.get(e.valid_up_to()).copied().unwrap_or_default();
        wrong(line_after(before), &format!("byte 0x{byte:02x}"))
    })?;
    match bytes.iter().position(|b| *b == 0) {
        Some(at) => Err(wrong(line_after(&bytes[..at]), "a NUL byte")),
        None => Ok(text),
    }
}

/// Returns the number of the line on which the byte after `before` stands.
fn line_after(before: &[u8]) -> usize {
    before.iter().filter(|b| **b == b'\n').count() + 1
}

/// Returns an error at a line. The found text is shortened, so that no message carries a whole file.
pub(crate) fn parse_error(file: &Path, line: usize, expected: impl Into<String>, got: &str) -> MotionError {
    let mut got: String = got.trim_end().chars().take(60).flat_map(printable).collect();
    if got.is_empty() {
        got.push_str("nothing");
    }
    MotionError::Parse { file: file.to_path_buf(), line, expected: expected.into(), got }
}

/// Returns a character as a message shows it.
fn printable(c: char) -> impl Iterator<Item = char> {
    let escaped = c.is_control().then(|| c.escape_default());
    escaped.into_iter().flatten().chain((!c.is_control()).then_some(c))
}

/// Lines of a text, with numbers. Blank lines are skipped, and comments on lines of their own.
#[derive(Clone)]
pub(crate) struct Lines<'a> {
    file: PathBuf,
    lines: std::str::Split<'a, char>,
    number: usize,
    comments: &'static [&'static str],
}

impl<'a> Lines<'a> {
    pub(crate) fn new(text: &'a str, file: &Path) -> Self {
        // Old Macintosh programs end lines by a carriage return alone.
        let end = if text.contains('\n') { '\n' } else { '\r' };
        let mut lines = text.strip_suffix(end).unwrap_or(text).split(end);
        if text.is_empty() {
            lines.next();
        }
        Self { file: file.to_path_buf(), lines, number: 0, comments: &[] }
    }

    /// Skips lines that begin with one of these.
    pub(crate) fn without_comments(self, comments: &'static [&'static str]) -> Self {
        Self { comments, ..self }
    }

    /// Returns the number of the line that came last (from 1).
    pub(crate) fn number(&self) -> usize {
        self.number
    }

    /// Returns the next line that is not blank, without white space around it.
    pub(crate) fn next_line(&mut self) -> Option<&'a str> {
        loop {
            let line = self.lines.next()?;
            self.number += 1;
            let line = line.trim();
            if !line.is_empty() && !self.comments.iter().any(|mark| line.starts_with(mark)) {
                return Some(line);
            }
        }
    }

    /// Returns the next line, or an error that says what should have been there.
    pub(crate) fn expect(&mut self, expected: &str) -> Result<&'a str, MotionError> {
        match self.next_line() {
            Some(line) => Ok(line),
            None => Err(parse_error(&self.file, self.number + 1, expected, "the end of the file")),
        }
    }

    /// Returns an error at the line that came last.
    pub(crate) fn error(&self, expected: impl Into<String>, got: &str) -> MotionError {
        parse_error(&self.file, self.number, expected, got)
    }

    /// Returns an error at another line.
    pub(crate) fn error_at(&self, line: usize, expected: impl Into<String>, got: &str) -> MotionError {
        parse_error(&self.file, line, expected, got)
    }

    /// Returns a finite number of a size that makes sense.
    pub(crate) fn number_in(&self, token: Option<&str>, expected: &str) -> Result<f64, MotionError> {
        let token = token.unwrap_or_default();
        match token.parse::<f64>() {
            Ok(value) if value.abs() <= LARGEST => Ok(value),
            _ => Err(self.error(expected, token)),
        }
    }

    /// Reads exactly `N` numbers, and nothing after them.
    pub(crate) fn numbers<const N: usize>(
        &self,
        mut tokens: std::str::SplitAsciiWhitespace<'_>,
        expected: &str,
    ) -> Result<[f64; N], MotionError> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.number_in(tokens.next(), expected)?;
        }
        match tokens.next() {
            Some(extra) => Err(self.error(format!("{expected} and no more"), extra)),
            None => Ok(values),
        }
    }
}
