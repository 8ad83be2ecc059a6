//! Mutual information between codes and motion (thesis 4.3.2).
//!
//! Every dimension of the codes is discretised into 100 bins of equal width between its smallest and its largest
//! value. The thesis leaves open the other side of a pair ("state", "input motion", "each pair of features") and the
//! unit. It does not say either how that is discretised, and how pairs become one score. Here it is each feature of
//! eq. 4.1 at the code's frame, discretised alike; information is in nats; the score is the mean over all pairs of a
//! feature and a dimension.
//!
//! An estimate from a histogram is too large: independent columns of T samples in B filled bins each have about (B -
//! 1)² / 2T nats too much (Miller 1955). For 50,000 samples that is 0.1 nats. That is why [`Information::shuffled`],
//! the same estimate after the codes have been dealt to frames at random, stands beside the score. Frames that follow
//! each other are alike, so the true bias is larger than that.

use lifelike_checkpoint::rng::stream;
use rand::seq::SliceRandom;
use rayon::prelude::*;

use super::codes::Codes;
use crate::{FromInput, RepresentationError};

/// Bins per dimension (thesis 4.3.2).
pub const BINS: usize = 100;

/// Mutual information of motion and codes.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Information {
    /// Mean over all pairs of a feature and a code dimension (nats).
    pub mean: f64,
    /// The same for codes that were dealt to the frames at random: what the estimate gives where there is nothing.
    pub shuffled: f64,
    /// Mean over features of what the most telling dimension knows (nats).
    pub best: f64,
}

/// Returns information that codes have of features.
///
/// # Shapes
/// `features: [T, F]` for the `T` codes.
///
/// # Errors
/// Features that are not as many rows as there are codes, and features that are not finite.
pub fn information(features: &[f32], codes: &Codes, seed: u64) -> Result<Information, RepresentationError> {
    let pairs = pairs(features, codes)?;
    let best = pairs.chunks_exact(codes.dimension()).map(|row| row.iter().copied().fold(0.0, f64::max));
    let best: Vec<f64> = best.collect();
    let mut order: Vec<usize> = (0..codes.len()).collect();
    order.shuffle(&mut stream(seed, "latent.shuffle", 0, 0));
    let rows = order.iter().flat_map(|row| codes.row(*row)).copied().collect();
    let dealt = Codes::new(vec!["shuffled".into()], vec![0, codes.len()], rows, codes.dimension(), codes.fps())?;
    Ok(Information { mean: mean(&pairs), shuffled: mean(&self::pairs(features, &dealt)?), best: mean(&best) })
}

/// Returns mutual information of each feature with each code dimension (nats); 0 where either is constant.
///
/// # Shapes
/// `features: [T, F]` to `[F, d]`.
///
/// # Errors
/// As [`information`].
pub fn pairs(features: &[f32], codes: &Codes) -> Result<Vec<f64>, RepresentationError> {
    let wrong = |expected: String, got: String| {
        Err(RepresentationError::mismatch("features beside latent codes", expected, got))
    };
    if codes.is_empty() || features.is_empty() || !features.len().is_multiple_of(codes.len()) {
        return wrong(format!("{} rows of features", codes.len()), format!("{} numbers", features.len()));
    }
    if let Some(bad) = features.iter().find(|x| !x.is_finite()) {
        return wrong("finite numbers".into(), bad.to_string());
    }
    let width = features.len() / codes.len();
    let of_codes: Vec<Option<Binned>> =
        (0..codes.dimension()).into_par_iter().map(|j| Binned::of(codes.rows(), codes.dimension(), j)).collect();
    let of_feature = |i| {
        let feature = Binned::of(features, width, i);
        let pair = |code: &Option<Binned>| feature.as_ref().zip(code.as_ref()).map_or(0.0, |(f, c)| f.shared_with(c));
        of_codes.iter().map(pair).collect::<Vec<f64>>()
    };
    Ok((0..width).into_par_iter().flat_map_iter(of_feature).collect())
}

/// A column as bin numbers.
struct Binned {
    bins: Vec<u8>,
    /// Samples per bin.
    counts: [u32; BINS],
}

impl Binned {
    /// Returns the column `at` of rows of `width`; `None` when it is constant.
    fn of(rows: &[f32], width: usize, at: usize) -> Option<Self> {
        let column = || rows.iter().skip(at).step_by(width).map(|x| f64::from(*x));
        let (low, high) = column().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        if low >= high {
            return None;
        }
        let bin = |x: f64| (((x - low) / (high - low) * BINS as f64) as usize).min(BINS - 1);
        let mut counts = [0; BINS];
        let bins = column().map(bin).inspect(|b| counts[*b] += 1).map(|b| b as u8).collect();
        Some(Self { bins, counts })
    }

    /// Returns mutual information (nats): Σ p(a, b) ln(p(a, b) / p(a) p(b)).
    fn shared_with(&self, other: &Self) -> f64 {
        let mut joint = vec![0_u32; BINS * BINS];
        for (a, b) in self.bins.iter().zip(&other.bins) {
            joint[usize::from(*a) * BINS + usize::from(*b)] += 1;
        }
        let total = self.bins.len() as f64;
        let mut sum = 0.0;
        for (row, a) in joint.chunks_exact(BINS).zip(self.counts) {
            for (&both, b) in row.iter().zip(other.counts).filter(|(both, _)| **both > 0) {
                let both = f64::from(both);
                sum += both * (both * total / (f64::from(a) * f64::from(b))).ln();
            }
        }
        // Rounding must not make less than nothing of it.
        (sum / total).max(0.0)
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn codes(column: Vec<f32>) -> Codes {
        Codes::new(vec!["a".into()], vec![0, column.len()], column, 1, 50.0).unwrap()
    }

    #[test]
    fn by_hand() {
        // Four samples in two bins each: (0, 0), (0, 1), (1, 1), (1, 1).
        // I = 1/4 ln(1/4 / (1/2 1/4)) + 1/4 ln(1/4 / (1/2 3/4)) + 1/2 ln(1/2 / (1/2 3/4)).
        let expected = 0.25 * 2.0_f64.ln() + 0.25 * (2.0_f64 / 3.0).ln() + 0.5 * (4.0_f64 / 3.0).ln();
        let got = pairs(&[0.0, 0.0, 1.0, 1.0], &codes(vec![0.0, 1.0, 1.0, 1.0])).unwrap();
        assert!((got[0] - expected).abs() < 1e-12, "{got:?} {expected}");
    }

    #[test]
    fn a_column_knows_all_of_itself_and_nothing_of_a_constant() {
        // A hundred values, one per bin: ln 100 nats, whatever the scale, and however the other side is turned round.
        let values: Vec<f32> = (0..200).map(|i| (i % 100) as f32 / 7.0).collect();
        let turned = values.iter().map(|x| -3.0 * x).collect();
        let got = pairs(&values, &codes(turned)).unwrap();
        assert!((got[0] - 100.0_f64.ln()).abs() < 1e-9, "{got:?}");
        assert_eq!(pairs(&values, &codes(vec![0.3; 200])).unwrap(), [0.0]);
        assert_eq!(pairs(&[0.3; 200], &codes(values)).unwrap(), [0.0]);
    }

    #[test]
    fn features_must_fit() {
        let three = codes(vec![0.0, 1.0, 2.0]);
        assert!(pairs(&[0.0; 4], &three).unwrap_err().to_string().contains("3 rows"));
        assert!(pairs(&[], &three).is_err());
        assert!(pairs(&[0.0, f32::INFINITY, 0.0], &three).unwrap_err().to_string().contains("finite"));
    }
}
