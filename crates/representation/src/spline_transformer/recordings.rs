//! Stretches of recorded motion: rows of numbers, one for every frame, cut into windows of one length.
//!
//! Training, validation and test are told apart by whole recordings, by whoever makes them (by subject, for the
//! tables): windows of one recording overlap, so a split among windows would test on what was trained on.

use std::ops::Range;

use lifelike_checkpoint::rng::stream;
use rand::Rng;
use sha2::{Digest, Sha256};

use super::sequences::{HeldOut, Sequences};
use crate::RepresentationError;
use lifelike_train::limits::wrong;

/// One recording at the frame rate of all.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// For messages.
    pub name: String,
    /// `[frames, width]`, row-major, in the units that the network works in.
    pub rows: Vec<f32>,
}

/// Recordings by what they are for.
#[derive(Debug, Clone, PartialEq)]
pub struct Split {
    /// To train on.
    pub training: Vec<Recording>,
    /// For the curve of the loss.
    pub validation: Vec<Recording>,
    /// For the tables.
    pub test: Vec<Recording>,
}

/// Windows of recordings.
///
/// Training windows begin at any frame, all equally likely. Held-out ones stand end to end, so every frame counts once (a rest
/// shorter than a window is left out).
#[derive(Debug)]
pub struct RecordingWindows {
    what: String,
    width: usize,
    tokens: usize,
    seed: u64,
    training: Vec<Recording>,
    /// Training windows that begin before each recording.
    before: Vec<usize>,
    windows: usize,
    validation: Vec<f32>,
    test: Vec<f32>,
}

impl RecordingWindows {
    /// Windows of `tokens` frames of `width` numbers. Recordings shorter than a window have none.
    ///
    /// `what` says what the numbers are, for [`Sequences::describe`].
    ///
    /// # Errors
    /// Rows that do not hold whole frames of finite numbers; nothing to train on.
    pub fn new(what: &str, width: usize, tokens: usize, seed: u64, split: Split) -> Result<Self, RepresentationError> {
        let unit = tokens * width;
        if unit == 0 {
            return Err(wrong("window", "at least one number", "none").into());
        }
        let mut hash = Sha256::new();
        for recording in [&split.training, &split.validation, &split.test].into_iter().flatten() {
            let broken = recording.rows.iter().position(|x| !x.is_finite());
            if let Some(row) = broken.or((recording.rows.len() % width != 0).then_some(recording.rows.len())) {
                let expected = format!("whole frames of {width} finite numbers");
                return Err(wrong(&recording.name, &expected, format!("frame {} that is not", row / width)).into());
            }
            recording.rows.iter().for_each(|x| hash.update(x.to_le_bytes()));
        }
        let digest: String = hash.finalize().iter().take(8).map(|b| format!("{b:02x}")).collect();
        let (mut before, mut windows) = (Vec::with_capacity(split.training.len()), 0);
        for recording in &split.training {
            before.push(windows);
            windows += (recording.rows.len() / width + 1).saturating_sub(tokens);
        }
        if windows == 0 {
            let longest = split.training.iter().map(|r| r.rows.len() / width).max();
            let got = longest.map_or("none".into(), |frames| format!("one of at most {frames}"));
            return Err(wrong("clips", &format!("a training recording of {tokens} frames"), got).into());
        }
        let end_to_end = |recordings: &[Recording]| -> Vec<f32> {
            recordings.iter().flat_map(|r| r.rows.chunks_exact(unit)).flatten().copied().collect()
        };
        let (validation, test) = (end_to_end(&split.validation), end_to_end(&split.test));
        let what = format!("{what}, windows of {tokens}, seed {seed}, {digest}");
        Ok(Self { what, width, tokens, seed, training: split.training, before, windows, validation, test })
    }

    /// Returns the number of training windows, overlapping.
    pub fn training_len(&self) -> usize {
        self.windows
    }

    fn all(&self, set: HeldOut) -> &[f32] {
        match set {
            HeldOut::Validation => &self.validation,
            HeldOut::Test => &self.test,
        }
    }

    fn training_window(&self, window: usize) -> &[f32] {
        let recording = self.before.partition_point(|before| *before <= window).saturating_sub(1);
        let first = (window - self.before[recording]) * self.width;
        &self.training[recording].rows[first..first + self.tokens * self.width]
    }
}

impl Sequences for RecordingWindows {
    fn describe(&self) -> String {
        self.what.clone()
    }

    fn width(&self) -> usize {
        self.width
    }

    fn tokens(&self) -> usize {
        self.tokens
    }

    fn batch(&self, iteration: u64, count: usize) -> Vec<f32> {
        let draw = |i| stream(self.seed, "recordings.training", i, iteration).random_range(0..self.windows);
        (0..count as u64).flat_map(|i| self.training_window(draw(i))).copied().collect()
    }

    fn held_out_len(&self, set: HeldOut) -> usize {
        self.all(set).len() / (self.tokens * self.width)
    }

    fn held_out(&self, set: HeldOut, range: Range<usize>) -> Vec<f32> {
        let unit = self.tokens * self.width;
        self.all(set)[range.start * unit..range.end * unit].to_vec()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::collections::BTreeSet;

    use super::*;

    /// Returns a recording whose numbers say where they are: 1000 × recording + frame, and the negative of it.
    fn recording(number: usize, frames: usize) -> Recording {
        let rows = (0..frames).flat_map(|f| [(1000 * number + f) as f32, -((1000 * number + f) as f32)]).collect();
        Recording { name: format!("clip {number}"), rows }
    }

    fn windows() -> RecordingWindows {
        let split = Split {
            training: vec![recording(1, 5), recording(2, 2), recording(3, 4)],
            validation: vec![recording(4, 3)],
            test: vec![recording(5, 7), recording(6, 2), recording(7, 3)],
        };
        RecordingWindows::new("numbers", 2, 3, 0, split).unwrap()
    }

    #[test]
    fn training_windows_begin_anywhere_and_never_cross_recordings() {
        let windows = windows();
        assert_eq!(windows.training_len(), 3 + 2);
        let mut begun = BTreeSet::new();
        for window in windows.batch(0, 200).chunks(6) {
            let first = window[0];
            assert_eq!(window, [first, -first, first + 1.0, -first - 1.0, first + 2.0, -first - 2.0]);
            begun.insert(first as usize);
        }
        assert_eq!(begun, [1000, 1001, 1002, 3000, 3001].into());
        assert_eq!(windows.batch(7, 3), windows.batch(7, 5)[..18]);
        assert_ne!(windows.batch(7, 30), windows.batch(8, 30));
    }

    #[test]
    fn held_out_windows_stand_end_to_end() {
        let windows = windows();
        assert_eq!((windows.held_out_len(HeldOut::Validation), windows.held_out_len(HeldOut::Test)), (1, 3));
        let firsts: Vec<f32> = windows.held_out(HeldOut::Test, 0..3).chunks(6).map(|w| w[0]).collect();
        assert_eq!(firsts, [5000.0, 5003.0, 7000.0]);
        assert_eq!(windows.held_out(HeldOut::Test, 1..2), windows.held_out(HeldOut::Test, 0..3)[6..12]);
    }

    #[test]
    fn other_numbers_are_described_otherwise_and_bad_ones_are_refused() {
        let split = |training| Split { training, validation: vec![], test: vec![] };
        let of = |training| RecordingWindows::new("numbers", 2, 3, 0, split(training));
        let (one, two) = (of(vec![recording(1, 5)]).unwrap(), of(vec![recording(2, 5)]).unwrap());
        assert_ne!(one.describe(), two.describe());
        let error = of(vec![recording(1, 2)]).unwrap_err().to_string();
        assert_eq!(error, "plan: clips: expected a training recording of 3 frames, got one of at most 2");
        let mut broken = recording(1, 5);
        broken.rows[5] = f32::NAN;
        let error = of(vec![broken]).unwrap_err().to_string();
        assert_eq!(error, "plan: clip 1: expected whole frames of 2 finite numbers, got frame 2 that is not");
        let mut short = recording(1, 5);
        short.rows.pop();
        assert!(of(vec![short]).unwrap_err().to_string().contains("frame 4"));
        assert!(of(vec![]).unwrap_err().to_string().contains("got none"));
    }
}
