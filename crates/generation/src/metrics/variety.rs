//! Diversity of motions, and multimodality: their diversity under one sentence.

use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::embeddings::{Embeddings, distance};
use crate::{FromInput, GenerationError};

/// Pairs of a diversity, as Guo et al. take them.
pub const DIVERSITY_PAIRS: usize = 300;
/// Pairs under each sentence of a multimodality.
pub const MULTIMODALITY_PAIRS: usize = 10;

/// Returns the mean distance of randomly drawn pairs. Both halves are drawn without repetition; where there are fewer
/// rows than `pairs`, all of them are drawn.
///
/// # Errors
/// [`GenerationError::Input`] for fewer than two rows.
pub fn diversity(embeddings: &Embeddings, pairs: usize, rng: &mut ChaCha8Rng) -> Result<f64, GenerationError> {
    embeddings.fits(embeddings, 2)?;
    let (sum, count) = drawn(embeddings, 0..embeddings.len(), pairs, rng);
    Ok(sum / count.max(1) as f64)
}

/// Returns the mean distance of pairs of motions under the same sentence.
///
/// # Shapes
/// `embeddings: [sentences * each, width]`, the motions of a sentence one after the other.
///
/// # Errors
/// [`GenerationError::Input`] for rows that make no whole sentences, or fewer than two motions of each.
pub fn multimodality(
    embeddings: &Embeddings,
    each: usize,
    pairs: usize,
    rng: &mut ChaCha8Rng,
) -> Result<f64, GenerationError> {
    if each < 2 || embeddings.is_empty() || !embeddings.len().is_multiple_of(each) {
        let expected = "two or more of every sentence, and as many of each";
        return Err(GenerationError::mismatch("motions", expected, format!("{} by {each}", embeddings.len())));
    }
    let (mut sum, mut count) = (0.0, 0);
    for first in (0..embeddings.len()).step_by(each) {
        let (own, pairs) = drawn(embeddings, first..first + each, pairs, rng);
        (sum, count) = (sum + own, count + pairs);
    }
    Ok(sum / count.max(1) as f64)
}

/// Returns the sum of the distances of drawn pairs, and their number.
fn drawn(embeddings: &Embeddings, rows: std::ops::Range<usize>, pairs: usize, rng: &mut ChaCha8Rng) -> (f64, usize) {
    let (mut first, mut second): (Vec<usize>, Vec<usize>) = (rows.clone().collect(), rows.collect());
    first.shuffle(rng);
    second.shuffle(rng);
    let count = pairs.min(first.len());
    let sum = first.iter().zip(&second).take(count).map(|(a, b)| distance(embeddings.row(*a), embeddings.row(*b)));
    (sum.sum(), count)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_checkpoint::rng::stream;

    use super::*;

    #[test]
    fn the_mean_over_many_draws_is_that_over_all_pairs() {
        // Distances of 0, 1, 3 on a line: with repetition over both halves (0 x 3 + 2 (1 + 3 + 2)) / 9.
        let points = Embeddings::new(vec![0.0, 1.0, 3.0], 1).unwrap();
        let draws = (0..4000).map(|i| diversity(&points, 1, &mut stream(1, "test", 0, i)).unwrap());
        let mean = draws.sum::<f64>() / 4000.0;
        // The standard deviation of one draw is 1.15, of the mean 0.018.
        assert!((mean - 12.0 / 9.0).abs() < 0.08, "{mean}");
    }

    #[test]
    fn sentences_are_not_mixed() {
        let far = Embeddings::new(vec![0.0, 0.0, 0.0, 100.0, 100.0, 100.0], 1).unwrap();
        assert_eq!(multimodality(&far, 3, 10, &mut stream(1, "test", 0, 0)).unwrap(), 0.0);
        assert!(diversity(&far, 6, &mut stream(1, "test", 0, 0)).unwrap() > 0.0);
        let told = multimodality(&far, 4, 10, &mut stream(1, "test", 0, 0)).unwrap_err().to_string();
        assert!(told.contains("got 6 by 4"), "{told}");
        assert!(diversity(&Embeddings::new(vec![1.0], 1).unwrap(), 3, &mut stream(1, "test", 0, 0)).is_err());
    }
}
