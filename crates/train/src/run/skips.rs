//! The end of a training that learns nothing any more: gradient after gradient is not finite.

use crate::TrainError;
use crate::error::DIVERGED;
use crate::task::Scalar;

/// Skipped gradients of a run.
#[derive(Debug, Default)]
pub(super) struct Skips {
    /// Number that was told last.
    told: f64,
    /// Iterations in a row that told a larger one.
    in_a_row: u64,
}

impl Skips {
    /// Follows an iteration's numbers. Every trainer tells its skipped gradients as `Gradient/skipped`.
    ///
    /// # Errors
    /// [`TrainError::Diverged`] after [`DIVERGED`] iterations in a row that each skipped one.
    pub fn follow(&mut self, scalars: &[Scalar], iteration: u64) -> Result<(), TrainError> {
        let Some((_, skipped)) = scalars.iter().find(|(name, _)| name == "Gradient/skipped") else { return Ok(()) };
        self.in_a_row = if *skipped > self.told { self.in_a_row + 1 } else { 0 };
        self.told = *skipped;
        if self.in_a_row >= DIVERGED { Err(TrainError::Diverged { iteration }) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_hundred_in_a_row_end_a_run_and_single_ones_do_not() {
        let mut skips = Skips::default();
        let mut tell = |skipped: u64| skips.follow(&[("Gradient/skipped".into(), skipped as f64)], 7);
        for iteration in 0..500 {
            tell(iteration / 2).unwrap();
        }
        let ends = (250..).position(|skipped| tell(skipped).is_err()).unwrap();
        assert_eq!(ends as u64 + 1, DIVERGED);
    }
}
