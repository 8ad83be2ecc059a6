//! From one motion to another through the latent space (thesis 4.3.2): codes of two clips are interpolated linearly, each is
//! decoded, and the middle frames of the decoded windows are a new motion.

use lifelike_character::Character;
use lifelike_motion::resample::locate;

use super::unroll::{Unrolled, unroll};
use crate::MotionPrior;
use crate::{FromInput, RepresentationError};

/// Share of the second clip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Blend {
    /// The same share throughout: 0 is the first clip, 1 the second.
    Constant(f64),
    /// From the first clip at the begin to the second at the end.
    Ramp,
}

impl Blend {
    /// Returns the second clip's share at a share of the way through.
    fn at(self, way: f64) -> f64 {
        match self {
            Self::Constant(weight) => weight,
            Self::Ramp => way,
        }
    }
}

/// A trajectory of codes between two others.
#[derive(Debug, Clone, PartialEq)]
pub struct Blended {
    /// `[T, d]`.
    pub rows: Vec<f32>,
    /// Frames of the originals that pass per frame, `[T]`: what the codes' velocities are multiplied by.
    pub pace: Vec<f64>,
}

/// Interpolates linearly between two trajectories of codes, both stretched to a common length.
///
/// The thesis does not give the length. Here it lies between the two as the (mean) weight says. Under a constant
/// weight the stretching of one and the shortening of the other leave the blend at its natural pace.
///
/// # Shapes
/// `a: [Ta, d]`, `b: [Tb, d]` to `[T, d]`.
///
/// # Errors
/// A weight outside of 0 to 1; rows that are not of `d` numbers, or none.
pub fn blend(a: &[f32], b: &[f32], d: usize, blend: Blend) -> Result<Blended, RepresentationError> {
    if let Blend::Constant(weight) = blend
        && !(0.0..=1.0).contains(&weight)
    {
        return Err(RepresentationError::mismatch("weight of an interpolation", "a number from 0 to 1", weight));
    }
    for codes in [a, b] {
        if d == 0 || codes.is_empty() || !codes.len().is_multiple_of(d) {
            let (expected, got) = (format!("rows of {d} numbers, at least one"), format!("{} numbers", codes.len()));
            return Err(RepresentationError::mismatch("latent codes to interpolate", expected, got));
        }
    }
    let steps = |codes: &[f32]| (codes.len() / d - 1) as f64;
    let between = |a: f64, b: f64, weight: f64| a + (b - a) * weight;
    let last = between(steps(a), steps(b), blend.at(0.5)).round();
    let (mut rows, mut pace) = (Vec::new(), Vec::new());
    for i in 0..=last as usize {
        let way = if last > 0.0 { i as f64 / last } else { 0.0 };
        let weight = blend.at(way);
        let (from, to) = (code_at(a, d, way * steps(a)), code_at(b, d, way * steps(b)));
        rows.extend(from.zip(to).map(|(a, b)| between(a, b, weight) as f32));
        pace.push(if last > 0.0 { between(steps(a), steps(b), weight) / last } else { 1.0 });
    }
    Ok(Blended { rows, pace })
}

/// Returns the code between two rows.
fn code_at(codes: &[f32], d: usize, index: f64) -> impl Iterator<Item = f64> {
    let (before, share) = locate(index, codes.len() / d);
    let after = (before + 1).min(codes.len() / d - 1);
    let row = |i: usize| codes[i * d..(i + 1) * d].iter().map(|x| f64::from(*x));
    row(before).zip(row(after)).map(move |(a, b)| a + (b - a) * share)
}

/// Returns the motion between two clips, given by their codes at the prior's frame rate.
///
/// # Errors
/// As [`blend`] and [`unroll`].
pub fn interpolate(
    prior: &MotionPrior,
    character: &Character,
    a: &[f32],
    b: &[f32],
    how: Blend,
) -> Result<Unrolled, RepresentationError> {
    let between = blend(a, b, prior.latent_size(), how)?;
    let features = middle_frames(prior, &between.rows)?;
    unroll(&features, &between.pace, prior.layout(), prior.windows().frame_rate, character)
}

/// Features (SI) of the middle frame of each code's window, in its own heading frame.
///
/// # Shapes
/// `[T, d]` to `[T, F]`.
pub fn middle_frames(prior: &MotionPrior, codes: &[f32]) -> Result<Vec<f64>, RepresentationError> {
    /// Codes at a time: a decoded window is some hundred times as large as its code.
    const CHUNK: usize = 256;
    let (size, window) = (prior.layout().size(), prior.windows().window().len() * prior.layout().size());
    let middle = prior.windows().half_width * size;
    let mut out = Vec::with_capacity(codes.len() / prior.latent_size() * size);
    for part in codes.chunks(CHUNK * prior.latent_size()) {
        let decoded = prior.decode(part)?;
        decoded.chunks_exact(window).for_each(|w| out.extend_from_slice(&w[middle..middle + size]));
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn by_hand() {
        // 3 and 5 codes: half way has 2 + 2/2 = 3 steps. At a third of the way: a at 2/3, b at 4/3 of a step.
        let (a, b) = ([0.0, 3.0, 6.0], [100.0, 110.0, 120.0, 130.0, 140.0]);
        let half = blend(&a, &b, 1, Blend::Constant(0.5)).unwrap();
        let expected = [50.0, 0.5 * (2.0 + 100.0 + 40.0 / 3.0), 0.5 * (4.0 + 100.0 + 80.0 / 3.0), 73.0];
        for (g, e) in half.rows.iter().zip(expected) {
            assert!((f64::from(*g) - e).abs() < 1e-4, "{:?}", half.rows);
        }
        assert_eq!((half.rows.len(), &half.pace), (4, &vec![1.0; 4]), "a weight's blend is at its natural pace");
        // The ramp: the first clip's pace of 2 codes in 3 frames at the begin, the second's of 4 in 3 at the end.
        let ramp = blend(&a, &b, 1, Blend::Ramp).unwrap();
        assert_eq!((ramp.rows[0], ramp.rows[3]), (0.0, 140.0));
        assert!((ramp.pace[0] - 2.0 / 3.0).abs() < 1e-12 && (ramp.pace[3] - 4.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn the_ends_are_the_clips_themselves() {
        let (a, b) = ([1.0, 2.0, 3.0, 5.0, 8.0, 13.0], [0.0, 1.0]);
        assert_eq!(blend(&a, &b, 2, Blend::Constant(0.0)).unwrap().rows, a);
        assert_eq!(blend(&a, &b, 2, Blend::Constant(1.0)).unwrap(), Blended { rows: b.to_vec(), pace: vec![1.0] });
    }

    #[test]
    fn misuse_is_an_error() {
        for weight in [-0.1, 1.1, f64::NAN] {
            assert!(blend(&[1.0], &[1.0], 1, Blend::Constant(weight)).unwrap_err().to_string().contains("0 to 1"));
        }
        assert!(blend(&[], &[1.0], 1, Blend::Ramp).is_err());
        assert!(blend(&[1.0; 3], &[1.0; 2], 2, Blend::Ramp).unwrap_err().to_string().contains("rows of 2"));
    }
}
