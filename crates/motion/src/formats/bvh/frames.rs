//! The numbers of the frames: a frame a line, or wrapped as the tokens that they are to readers by white space.

use std::iter::Peekable;
use std::str::SplitAsciiWhitespace;

use crate::error::MotionError;
use crate::formats::text::Lines;

/// Numbers of the frames that are left.
pub(super) struct Numbers<'a> {
    pub(super) lines: Lines<'a>,
    /// Numbers of the last line that are left.
    tokens: Peekable<SplitAsciiWhitespace<'a>>,
    is_wrapped: bool,
}

impl<'a> Numbers<'a> {
    /// Lines are ignored where the first one is no frame and all numbers together are those of the frames, or of one more.
    pub(super) fn new(lines: Lines<'a>, channels: usize, frames: usize) -> Self {
        let mut ahead = lines.clone();
        let mut count = || ahead.next_line().map(|line| line.split_ascii_whitespace().count());
        let first = count().unwrap_or(channels);
        let is_wrapped = first != channels && {
            let all = first + std::iter::from_fn(count).sum::<usize>();
            [Some(all), all.checked_sub(channels)].contains(&frames.checked_mul(channels))
        };
        Self { lines, tokens: "".split_ascii_whitespace().peekable(), is_wrapped }
    }

    /// Reads a frame; `false` at the end of the file.
    pub(super) fn read(&mut self, channels: &mut [f64]) -> Result<bool, MotionError> {
        if !self.fill() {
            return Ok(false);
        }
        for value in channels.iter_mut() {
            if self.is_wrapped {
                self.fill();
            }
            *value = self.lines.number_in(self.tokens.next(), "a number for each channel")?;
        }
        if !self.is_wrapped && self.tokens.peek().is_some() {
            let got = format!("{} numbers", channels.len() + self.tokens.by_ref().count());
            return Err(self.lines.error(format!("{} numbers, one per channel", channels.len()), &got));
        }
        Ok(true)
    }

    /// Goes to the next line where none of this one is left; `false` at the end of the file.
    fn fill(&mut self) -> bool {
        while self.tokens.peek().is_none() {
            let Some(line) = self.lines.next_line() else { return false };
            self.tokens = line.split_ascii_whitespace().peekable();
        }
        true
    }
}
