//! Numbers of a motion that are given: its beginning, body parts, poses at moments.

/// Values, and which of them are known.
#[derive(Debug, Clone, PartialEq)]
pub struct Known {
    values: Vec<f32>,
    mask: Vec<bool>,
    width: usize,
}

impl Known {
    /// Returns a motion, `[tokens, width]`, of which nothing is known yet.
    pub fn nothing(values: Vec<f32>, width: usize) -> Self {
        Self { mask: vec![false; values.len()], values, width }
    }

    /// With its first tokens known: streaming goes on from them.
    #[must_use]
    pub fn prefix(mut self, tokens: usize) -> Self {
        let count = (tokens * self.width).min(self.mask.len());
        self.mask[..count].fill(true);
        self
    }

    /// With columns known throughout: body parts.
    #[must_use]
    pub fn columns(mut self, columns: &[usize]) -> Self {
        for row in self.mask.chunks_exact_mut(self.width.max(1)) {
            columns.iter().filter(|c| **c < self.width).for_each(|c| row[*c] = true);
        }
        self
    }

    /// With these tokens known, each the same.
    #[must_use]
    pub fn tokens(mut self, tokens: std::ops::Range<usize>, token: &[f32]) -> Self {
        let at = tokens.start * self.width..(tokens.end * self.width).min(self.mask.len());
        self.mask[at.clone()].fill(true);
        self.values[at].chunks_exact_mut(self.width.max(1)).for_each(|own| own.copy_from_slice(token));
        self
    }

    /// Puts what is known in its place.
    pub fn put(&self, motion: &mut [f32]) {
        for ((x, value), known) in motion.iter_mut().zip(&self.values).zip(&self.mask) {
            if *known {
                *x = *value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_known_is_put() {
        let known = |known: Known| {
            let mut x = vec![0.0; 6];
            known.put(&mut x);
            x
        };
        let nothing = || Known::nothing(vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 2);
        assert_eq!(known(nothing()), [0.0; 6]);
        assert_eq!(known(nothing().prefix(2)), [1.0, 2.0, 3.0, 4.0, 0.0, 0.0]);
        assert_eq!(known(nothing().columns(&[1, 7])), [0.0, 2.0, 0.0, 4.0, 0.0, 6.0]);
        assert_eq!(known(nothing().prefix(100)), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(known(nothing().tokens(1..3, &[7.0, 8.0])), [0.0, 0.0, 7.0, 8.0, 7.0, 8.0]);
    }
}
