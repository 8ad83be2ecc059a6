//! Separation of motions by their codes: Linear Discriminant Analysis (Bishop 1995) as thesis 4.3.2 uses it.
//!
//! A class is [`CLASS_SECONDS`] of one clip; as much after it is left out, so that neighbouring classes are distinct. A
//! remainder at a clip's end that is shorter than a class belongs to none. All classes are therefore of one size and
//! equally likely.
//!
//! The thesis does not say on which codes it measures accuracy. [`LdaScore::accuracy`] is on the codes that the
//! classifier was fitted to, as its text reads. [`LdaScore::held_out_accuracy`] is our own: fitted to every other
//! [`BLOCK_SECONDS`] of each class and measured on those between. It is a milder test than unseen motion would be, as
//! windows around neighbouring frames share most of their samples.

use std::ops::Range;

use nalgebra::linalg::SymmetricEigen;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::codes::Codes;
use crate::{FromInput, RepresentationError};

/// Length of a class, and of the gap after it (s).
pub const CLASS_SECONDS: f64 = 2.0;
/// Length of the blocks that are fitted and held out by turns (s).
pub const BLOCK_SECONDS: f64 = 0.25;
/// Directions whose standard deviation within classes is less than this, with every dimension scaled to 1, are left out.
/// scikit-learn's default.
const TOLERANCE: f64 = 1e-4;
/// A dimension's standard deviation within classes below this share of its size is rounding, not motion.
const ROUNDING: f64 = 1e-10;
/// Sweeps that the eigenvalues may take; they need about two per dimension.
const SWEEPS: usize = 10_000;

/// Scores of a classification of motion.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct LdaScore {
    /// Classes.
    pub classes: usize,
    /// Codes in them.
    pub frames: usize,
    /// Share of codes that the classifier gives back to their class, on the codes that it was fitted to.
    pub accuracy: f64,
    /// The same on held-out blocks of the classes.
    pub held_out_accuracy: f64,
    /// Accuracy of guessing: one over the number of classes.
    pub chance: f64,
}

/// Returns the accuracy of LDA on these codes.
///
/// # Errors
/// Fewer than two classes, or fewer than two codes per block.
pub fn lda(codes: &Codes) -> Result<LdaScore, RepresentationError> {
    let classes = classes(codes);
    let mismatch = |what: &str, expected: String, got: String| RepresentationError::mismatch(what, expected, got);
    if classes.len() < 2 {
        let expected = format!("at least 2 stretches of {CLASS_SECONDS} s");
        return Err(mismatch("clips for LDA", expected, classes.len().to_string()));
    }
    if codes.fps() * BLOCK_SECONDS < 2.0 {
        let expected = format!("at least {}", 2.0 / BLOCK_SECONDS);
        return Err(mismatch("codes per second for LDA", expected, codes.fps().to_string()));
    }
    let whole: Vec<Vec<usize>> = classes.iter().map(|c| c.clone().collect()).collect();
    let half = |odd: bool| -> Vec<Vec<usize>> {
        let wanted = |c: &Range<usize>, row: &usize| block(row - c.start, codes.fps()) % 2 == usize::from(odd);
        classes.iter().map(|c| c.clone().filter(|row| wanted(c, row)).collect()).collect()
    };
    Ok(LdaScore {
        classes: classes.len(),
        frames: whole.iter().map(Vec::len).sum(),
        accuracy: Discriminant::fit(codes, &whole)?.accuracy(codes, &whole),
        held_out_accuracy: Discriminant::fit(codes, &half(false))?.accuracy(codes, &half(true)),
        chance: 1.0 / classes.len() as f64,
    })
}

/// Returns the rows of each class.
pub fn classes(codes: &Codes) -> Vec<Range<usize>> {
    let length = (CLASS_SECONDS * codes.fps()).round().max(1.0) as usize;
    let of = |clip: Range<usize>| {
        let (start, end) = (clip.start, clip.end);
        (start..end).step_by(2 * length).map(move |s| s..s + length).filter(move |c| c.end <= end)
    };
    codes.clips().flat_map(of).collect()
}

/// Returns the block that a class' so-manieth code is in.
fn block(offset: usize, fps: f64) -> usize {
    // Without the small share, rounding would put a code at a block's exact begin into the block before.
    (offset as f64 / (BLOCK_SECONDS * fps) + 1e-9) as usize
}

/// The classifier: the class whose mean is nearest, in coordinates in which the codes of all classes spread alike.
///
/// For equally likely classes with one covariance that is the most likely class. The covariance within classes is the most
/// likely one (a mean over all codes) and need not be regular: its pseudo-inverse is used, without shrinkage, as
/// scikit-learn's solver `svd` does.
#[derive(Debug, Clone)]
pub struct Discriminant {
    /// `[rank, d]`: codes to whitened coordinates.
    whitening: DMatrix<f64>,
    /// The classes' means there, `[rank, classes]`.
    means: DMatrix<f64>,
}

impl Discriminant {
    /// Fits it to the rows of each class; classes are taken as equally likely.
    ///
    /// # Errors
    /// An empty class, no more codes than classes, or eigenvalues that cannot be found.
    pub fn fit(codes: &Codes, classes: &[Vec<usize>]) -> Result<Self, RepresentationError> {
        let d = codes.dimension();
        let frames: usize = classes.iter().map(Vec::len).sum();
        if frames <= classes.len() || classes.iter().any(Vec::is_empty) {
            let expected = format!("more than one in each of {} classes", classes.len());
            return Err(RepresentationError::mismatch("codes for LDA", expected, frames));
        }
        let mut means = DMatrix::zeros(d, classes.len());
        let mut within = DMatrix::<f64>::zeros(d, d);
        let mut size = DVector::<f64>::zeros(d);
        for (k, rows) in classes.iter().enumerate() {
            let members = DMatrix::from_fn(d, rows.len(), |i, j| f64::from(codes.row(rows[j])[i]));
            let mean = members.column_mean();
            let centred = DMatrix::from_fn(d, rows.len(), |i, j| members[(i, j)] - mean[i]);
            within += &centred * centred.transpose();
            for (i, row) in members.row_iter().enumerate() {
                size[i] += row.norm_squared();
            }
            means.set_column(k, &mean);
        }
        let scale = DVector::from_fn(d, |i, _| {
            let std = (within[(i, i)] / frames as f64).sqrt();
            if std > ROUNDING * (size[i] / frames as f64).sqrt() { 1.0 / std } else { 0.0 }
        });
        let scaled = DMatrix::from_fn(d, d, |i, j| within[(i, j)] * scale[i] * scale[j] / frames as f64);
        let eigen = SymmetricEigen::try_new(scaled, f64::EPSILON, SWEEPS).ok_or_else(|| {
            RepresentationError::mismatch(
                "covariance of codes within classes",
                format!("eigenvalues within {SWEEPS} sweeps"),
                "none",
            )
        })?;
        let kept: Vec<usize> = (0..d).filter(|i| eigen.eigenvalues[*i] > TOLERANCE * TOLERANCE).collect();
        let whitening = DMatrix::from_fn(kept.len(), d, |r, i| {
            eigen.eigenvectors[(i, kept[r])] / eigen.eigenvalues[kept[r]].sqrt() * scale[i]
        });
        let means = &whitening * means;
        Ok(Self { whitening, means })
    }

    /// Returns the logarithm of each class' likelihood for a code, up to a sum that is the same for all classes.
    pub fn scores(&self, code: &[f32]) -> Vec<f64> {
        let here = &self.whitening * DVector::from_iterator(code.len(), code.iter().map(|x| f64::from(*x)));
        self.means.column_iter().map(|mean| -0.5 * (&here - mean).norm_squared()).collect()
    }

    /// Returns the most likely class of a code.
    pub fn classify(&self, code: &[f32]) -> usize {
        let scores = self.scores(code);
        // The first of equals, so that a space that knows nothing is right about one class only.
        (0..scores.len()).fold(0, |best, k| if scores[k] > scores[best] { k } else { best })
    }

    /// Returns the share of these rows that are given to their class.
    fn accuracy(&self, codes: &Codes, classes: &[Vec<usize>]) -> f64 {
        let right =
            |(k, rows): (usize, &Vec<usize>)| rows.iter().filter(|row| self.classify(codes.row(**row)) == k).count();
        let frames: usize = classes.iter().map(Vec::len).sum();
        classes.par_iter().enumerate().map(right).sum::<usize>() as f64 / frames.max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn codes(lengths: &[usize], fps: f64, code: impl Fn(usize, usize) -> [f32; 2]) -> Codes {
        let names = (0..lengths.len()).map(|i| i.to_string()).collect();
        let mut starts = vec![0];
        lengths.iter().for_each(|n| starts.push(starts[starts.len() - 1] + n));
        let rows = lengths.iter().enumerate().flat_map(|(c, n)| (0..*n).flat_map(move |i| [(c, i)]));
        Codes::new(names, starts, rows.flat_map(|(c, i)| code(c, i)).collect(), 2, fps).unwrap()
    }

    #[test]
    fn two_seconds_in_two_seconds_out_and_no_class_crosses_a_clip() {
        let codes = codes(&[100, 19, 20, 75], 10.0, |_, _| [0.0; 2]);
        assert_eq!(classes(&codes), [0..20, 40..60, 80..100, 119..139, 139..159, 179..199]);
        // Blocks of 2.5 codes begin at 0, 2.5, 5, 7.5.
        let blocks: Vec<usize> = (0..9).map(|i| block(i, 10.0)).collect();
        assert_eq!(blocks, [0, 0, 0, 1, 1, 2, 2, 2, 3]);
    }

    #[test]
    fn the_boundary_is_where_the_covariance_puts_it() {
        // Two classes around (-1, 0) and (1, 0) with the same covariance [[1, 0], [0, 4]]: y does not separate.
        let offsets: [[f32; 2]; 4] = [[1.0, 2.0], [-1.0, 2.0], [1.0, -2.0], [-1.0, -2.0]];
        let codes = codes(&[8], 1.0, |_, i| [offsets[i % 4][0] + if i < 4 { -1.0 } else { 1.0 }, offsets[i % 4][1]]);
        let found = Discriminant::fit(&codes, &[(0..4).collect(), (4..8).collect()]).unwrap();
        // The difference of scores at x: ((x + 1)² - (x - 1)²) / 2 over the variance along x, 1.
        for (x, y) in [(0.3, 0.0), (-0.7, 9.0), (0.0, 5.0)] {
            let scores = found.scores(&[x, y]);
            assert!((scores[1] - scores[0] - 2.0 * f64::from(x)).abs() < 1e-9, "{scores:?}");
        }
        assert_eq!((found.classify(&[0.1, -50.0]), found.classify(&[-0.1, 50.0])), (1, 0));
    }

    #[test]
    fn dimensions_that_say_nothing_are_left_out() {
        // The second dimension is constant, 0.1 being no binary fraction; the first tells classes apart.
        let codes = codes(&[40, 40], 10.0, |c, i| [5.0 * c as f32 + (i % 3) as f32, 0.1]);
        let score = lda(&codes).unwrap();
        assert_eq!((score.classes, score.frames, score.chance), (2, 40, 0.5));
        assert_eq!((score.accuracy, score.held_out_accuracy), (1.0, 1.0));
        // Nothing to tell them apart by: the first class wins always.
        let same = lda(&self::codes(&[40, 40], 10.0, |_, _| [0.1, 0.2])).unwrap();
        assert_eq!((same.accuracy, same.held_out_accuracy), (0.5, 0.5));
    }

    #[test]
    fn too_little_is_told() {
        assert!(lda(&codes(&[39], 10.0, |_, _| [0.0; 2])).unwrap_err().to_string().contains("got 1"));
        assert!(lda(&codes(&[99], 4.0, |_, _| [0.0; 2])).unwrap_err().to_string().contains("at least 8"));
    }
}
