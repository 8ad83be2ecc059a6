//! One entry of a data set as a task of the generators.

use lifelike_checkpoint::rng::stream;
use lifelike_language::Entry;
use rand::RngCore;

/// One sentence to make motion of.
#[derive(Debug, Clone, Copy)]
pub struct Task<'a> {
    /// Number in the data set: an entry's noise is the same whatever others are measured.
    number: usize,
    /// The entry.
    pub entry: &'a Entry,
}

impl<'a> From<(usize, &'a Entry)> for Task<'a> {
    fn from((number, entry): (usize, &'a Entry)) -> Self {
        Self { number, entry }
    }
}

impl Task<'_> {
    /// Returns the sentence: the first one.
    pub fn prompt(&self) -> &str {
        self.entry.captions.first().map_or("", String::as_str)
    }

    /// Returns the seed of one of its motions.
    pub fn seed(&self, seed: u64, repetition: u64) -> u64 {
        stream(seed, "bench.generation", self.number as u64, repetition).next_u64()
    }
}
