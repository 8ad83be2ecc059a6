//! Positions of tokens along a sequence.

use crate::spline::uniform;

/// Positions of tokens, in tokens of the sequence that was encoded: 0 is its first, `last` its last one.
///
/// Decoding more tokens than were encoded puts them at fractions. Distances and phases then mean what they meant in
/// training, however densely the latent curve is sampled.
#[derive(Debug, Clone, PartialEq)]
pub struct Sampling {
    positions: Vec<f64>,
    last: f64,
}

impl Sampling {
    /// Returns one token for each of `tokens`.
    pub fn each(tokens: usize) -> Self {
        Self::even(tokens, tokens)
    }

    /// `samples` tokens, evenly from the first to the last of `tokens`: any number, more or fewer.
    pub fn even(tokens: usize, samples: usize) -> Self {
        let last = tokens.saturating_sub(1) as f64;
        let scaled = |i: usize| i as f64 * last / samples.saturating_sub(1).max(1) as f64;
        Self { positions: (0..samples).map(scaled).collect(), last }
    }

    /// Tokens at these positions, from 0 to `tokens` − 1.
    pub fn at(positions: Vec<f64>, tokens: usize) -> Self {
        Self { positions, last: tokens.saturating_sub(1) as f64 }
    }

    /// Returns positions in tokens.
    pub fn positions(&self) -> &[f64] {
        &self.positions
    }

    /// Returns their number.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Returns whether there are none.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Returns the spline parameters, in `[0, 1]`.
    pub fn parameters(&self) -> Vec<f64> {
        if self.last == 0.0 {
            return uniform(self.len());
        }
        self.positions.iter().map(|p| (p / self.last).clamp(0.0, 1.0)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refining_keeps_what_there_was_and_the_scale() {
        for (tokens, factor) in [(2, 2), (61, 2), (61, 4), (100, 3), (1, 4)] {
            let (coarse, fine) = (Sampling::each(tokens), Sampling::even(tokens, (tokens - 1) * factor + 1));
            for i in 0..tokens {
                assert_eq!(coarse.positions()[i], i as f64);
                assert_eq!(fine.positions()[i * factor], i as f64);
                assert_eq!(fine.parameters()[i * factor], coarse.parameters()[i]);
            }
        }
        let some = Sampling::at(vec![0.0, 2.5, 9.0], 10);
        assert_eq!(some.parameters(), [0.0, 2.5 / 9.0, 1.0]);
        let twice = Sampling::even(10, 20);
        assert_eq!((twice.len(), twice.positions()[0], twice.positions()[19]), (20, 0.0, 9.0));
        assert!(Sampling::even(10, 0).is_empty());
    }
}
