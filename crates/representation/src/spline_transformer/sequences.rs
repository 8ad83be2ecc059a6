//! Data of a [`super::SequenceTrainer`].

use std::ops::Range;

/// Sequences that are never trained on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeldOut {
    /// Looked at during training, for the curve of the loss.
    Validation,
    /// Looked at when training is done, for the tables.
    Test,
}

/// A source of sequences of one length. All of its numbers are determined by itself and the arguments, so methods that are
/// given the same source meet the same batches, and a resumed run those that it would have met.
pub trait Sequences {
    /// Describes these sequences in a line: a run goes on only with a source that says the same.
    fn describe(&self) -> String;

    /// Returns the numbers of one element of a sequence.
    fn width(&self) -> usize;

    /// Elements of a sequence.
    fn tokens(&self) -> usize;

    /// Returns training sequences of one iteration (counted from 0).
    ///
    /// # Shapes
    /// `[count, tokens, width]`, row-major.
    fn batch(&self, iteration: u64, count: usize) -> Vec<f32>;

    /// Returns the number of sequences of a set.
    fn held_out_len(&self, set: HeldOut) -> usize;

    /// Returns some of a set.
    ///
    /// # Shapes
    /// `[range, tokens, width]`, row-major.
    fn held_out(&self, set: HeldOut, range: Range<usize>) -> Vec<f32>;
}

/// Reconstruction errors of held-out sequences.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SequenceErrors {
    /// Mean squared error over all numbers of all sequences.
    pub mse: f64,
    /// That of each sequence.
    pub each: Vec<f64>,
    /// Root mean square distance of control points from the mean of their own sequence's. Where it nears 0 all control
    /// points of a sequence are the same point: the collapse of thesis 3.3.5. Always 0 for one control point.
    pub spread: f64,
}

/// Sum of squared differences.
pub(super) fn squared(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum()
}
