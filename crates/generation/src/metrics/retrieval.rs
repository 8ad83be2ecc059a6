//! R-precision and MM-dist: does a sentence find its own motion among others?

use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::embeddings::{Embeddings, distance};
use crate::{FromInput, GenerationError};

/// Motions that a sentence is compared with, its own included.
pub const POOL: usize = 32;
/// Ranks that are counted: top 1 to top 3.
pub const TOP: usize = 3;

/// Results of a retrieval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Retrieval {
    /// Share of sentences whose own motion is among the nearest 1, 2, 3.
    pub precision: [f64; TOP],
    /// MM-dist: mean distance of a sentence and its own motion.
    pub distance: f64,
}

impl Retrieval {
    /// Measures over pools; row i of both belongs together. Motions equally near count as nearer than the own one: an
    /// encoder that gives one number for everything finds nothing.
    ///
    /// # Errors
    /// [`GenerationError::Input`] for embeddings of different sizes, no pool, or a row that is not there.
    pub fn of(text: &Embeddings, motion: &Embeddings, pools: &[Vec<usize>]) -> Result<Self, GenerationError> {
        let asked: usize = pools.iter().map(Vec::len).sum();
        if asked == 0 {
            return Err(GenerationError::mismatch("pools", "at least one", 0));
        }
        text.fits(motion, pools.iter().flatten().max().map_or(0, |last| last + 1))?;
        let (mut found, mut total) = ([0_usize; TOP], 0.0);
        for (pool, own) in pools.iter().flat_map(|pool| pool.iter().map(move |own| (pool, *own))) {
            let to_own = distance(text.row(own), motion.row(own));
            let nearer =
                pool.iter().filter(|i| **i != own && distance(text.row(own), motion.row(**i)) <= to_own).count();
            found.iter_mut().skip(nearer).for_each(|count| *count += 1);
            total += to_own;
        }
        let share = |count: usize| count as f64 / asked as f64;
        Ok(Self { precision: found.map(share), distance: total / asked as f64 })
    }
}

/// Draws pools of exactly `size` rows, as many as there are; a row is in one pool at most.
///
/// `kinds[i]` is the same for rows whose sentences are the same: no pool holds two of them, since neither would be
/// wrong for the other's sentence.
pub fn pools(kinds: &[usize], size: usize, rng: &mut ChaCha8Rng) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..kinds.len()).collect();
    order.shuffle(rng);
    let mut open: Vec<Vec<usize>> = Vec::new();
    let mut full = Vec::new();
    for row in order {
        let free = open.iter().position(|pool| pool.iter().all(|other| kinds[*other] != kinds[row]));
        let at = free.unwrap_or_else(|| {
            open.push(Vec::with_capacity(size));
            open.len() - 1
        });
        open[at].push(row);
        if open[at].len() == size {
            full.push(open.remove(at));
        }
    }
    full
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use lifelike_checkpoint::rng::stream;

    use super::*;

    #[test]
    fn pools_hold_every_sentence_once() {
        let kinds: Vec<usize> = (0..100).map(|i| i % 40).collect();
        let pools = pools(&kinds, 32, &mut stream(1, "test", 0, 0));
        assert!((2..=3).contains(&pools.len()));
        let mut rows: Vec<usize> = pools.iter().flatten().copied().collect();
        rows.sort_unstable();
        assert!(rows.windows(2).all(|pair| pair[0] < pair[1]));
        for pool in pools {
            let mut kinds: Vec<usize> = pool.iter().map(|i| kinds[*i]).collect();
            kinds.sort_unstable();
            kinds.dedup();
            assert_eq!(kinds.len(), 32);
        }
        assert!(super::pools(&[0; 64], 32, &mut stream(1, "test", 0, 0)).is_empty());
    }

    #[test]
    fn an_encoder_that_tells_nothing_apart_finds_nothing() {
        let same = Embeddings::new(vec![1.0; 64], 2).unwrap();
        let pool = vec![(0..32).collect()];
        assert_eq!(Retrieval::of(&same, &same, &pool).unwrap().precision, [0.0; 3]);
        let apart = Embeddings::new((0..64).map(|i| i as f32).collect(), 2).unwrap();
        let perfect = Retrieval::of(&apart, &apart, &pool).unwrap();
        assert_eq!((perfect.precision, perfect.distance), ([1.0; 3], 0.0));
        assert!(Retrieval::of(&apart, &apart, &[vec![40]]).unwrap_err().to_string().contains("at least 41, got 32"));
        assert!(Retrieval::of(&apart, &apart, &[]).is_err());
    }
}
