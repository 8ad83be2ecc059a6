//! Length of the motion that a sentence asks for: a number of seconds for each word, by ridge regression on captions.
//!
//! Words add up, so that two actions in a row get the time of both, and "five times" more than "twice".

use std::collections::BTreeMap;

use nalgebra::{Cholesky, DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::prompt;

/// Most words that are learned, the most frequent first.
const MAX_WORDS: usize = 1500;
/// Penalty on squared seconds of a word, in captions: a word in one caption gets half of what that caption says.
const PENALTY: f64 = 1.0;

/// Durations by words.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Durations {
    /// Duration of a sentence without a known word (s).
    constant: f64,
    /// Seconds that each word adds, every time it stands in a sentence.
    words: BTreeMap<String, f64>,
    /// Shortest and longest motion learned from (s).
    range: [f64; 2],
}

impl Durations {
    /// Learns from captions and the durations of their motions (s).
    pub fn learn<'a>(captions: impl IntoIterator<Item = (&'a str, f64)>) -> Self {
        let captions: Vec<(Vec<String>, f64)> =
            captions.into_iter().map(|(text, seconds)| (prompt::words(text), seconds)).collect();
        let mut seconds: Vec<f64> = captions.iter().map(|(_, seconds)| *seconds).collect();
        seconds.sort_by(f64::total_cmp);
        let (Some(shortest), Some(longest)) = (seconds.first(), seconds.last()) else { return Self::default() };
        let (median, range) = (seconds[seconds.len() / 2], [*shortest, *longest]);
        let vocabulary = vocabulary(&captions);
        // The last unknown is the constant beside the median.
        let size = vocabulary.len() + 1;
        let mut normal = DMatrix::from_diagonal_element(size, size, PENALTY);
        let mut right = DVector::zeros(size);
        for (words, seconds) in &captions {
            let mut row: BTreeMap<usize, f64> = BTreeMap::from([(size - 1, 1.0)]);
            for at in words.iter().filter_map(|word| vocabulary.get(word.as_str())) {
                *row.entry(*at).or_default() += 1.0;
            }
            for (i, x) in &row {
                row.iter().for_each(|(j, y)| normal[(*i, *j)] += x * y);
                right[*i] += x * (seconds - median);
            }
        }
        // The penalty makes the equations positive definite.
        let Some(factor) = Cholesky::new(normal) else { return Self { constant: median, range, ..Self::default() } };
        let found = factor.solve(&right);
        let words = vocabulary.iter().map(|(word, at)| ((*word).to_string(), found[*at])).collect();
        Self { constant: median + found[size - 1], words, range }
    }

    /// Returns how long a sentence's motion is (s), within what was learned from; none where nothing was learned.
    pub fn seconds(&self, text: &str) -> Option<f64> {
        let known: f64 = prompt::words(text).iter().filter_map(|word| self.words.get(word)).sum();
        let [shortest, longest] = self.range;
        (longest > 0.0).then(|| (self.constant + known).clamp(shortest, longest))
    }
}

/// Returns the most frequent words, each with a number.
fn vocabulary(captions: &[(Vec<String>, f64)]) -> BTreeMap<&str, usize> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    captions.iter().flat_map(|(words, _)| words).for_each(|word| *counts.entry(word).or_default() += 1);
    let mut words: Vec<(&str, usize)> = counts.into_iter().collect();
    words.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(b.0)));
    words.truncate(MAX_WORDS);
    words.into_iter().enumerate().map(|(at, (word, _))| (word, at)).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn actions_add_up_and_what_is_unknown_adds_nothing() {
        let learned = [("a person walks", 4.0), ("a person bows", 2.0), ("a person walks then a person bows", 6.0)];
        let durations = Durations::learn((0..40).flat_map(|_| learned));
        for (text, seconds) in learned {
            let found = durations.seconds(text).unwrap();
            assert!((found - seconds).abs() < 0.1, "{text}: {found}");
        }
        let same = |a: &str, b: &str| assert_eq!(durations.seconds(a), durations.seconds(b));
        same("A person walks!", "a person walks");
        same("a person gracefully walks", "a person walks");
        // Never longer than anything that was learned from.
        assert_eq!(durations.seconds("walks then walks then walks then bows"), Some(6.0));
        assert_eq!(Durations::default().seconds("a person walks"), None);
        assert_eq!(Durations::learn([("a person walks", 3.0)]).seconds("qwertys"), Some(3.0));
    }

    #[test]
    fn weights_are_those_of_the_normal_equations() {
        // A word and the constant, in seconds beside the median 3: (2 + 1) w + 2 c = 2 and 2 w + (3 + 1) c = 1.
        let durations = Durations::learn([("walk", 3.0), ("walk", 5.0), ("", 2.0)]);
        assert!((durations.words["walk"] - 0.75).abs() < 1e-12, "{durations:?}");
        assert!((durations.constant - 2.875).abs() < 1e-12, "{durations:?}");
    }
}
