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

/// A source of sequences of one length. All of its numbers are determined by itself and the arguments. Methods with
/// the same source therefore meet the same batches, and a resumed run those that it would have met.
pub trait Sequences: Sync {
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

    /// Returns the loss of what came back of some sequences, summed over their numbers, and writes its gradient by `y`: squared
    /// differences, where a source has no better.
    ///
    /// # Shapes
    /// All `[B, tokens, width]`, row-major.
    fn loss(&self, x: &[f32], y: &[f32], gradient: &mut [f32]) -> f64 {
        let mut sum = 0.0;
        for ((x, y), gradient) in x.iter().zip(y).zip(gradient) {
            *gradient = 2.0 * (y - x);
            sum += f64::from(y - x).powi(2);
        }
        sum
    }

    /// Returns the number of sequences of a set.
    fn held_out_len(&self, set: HeldOut) -> usize;

    /// Returns some of a set.
    ///
    /// # Shapes
    /// `[range, tokens, width]`, row-major.
    fn held_out(&self, set: HeldOut, range: Range<usize>) -> Vec<f32>;
}
