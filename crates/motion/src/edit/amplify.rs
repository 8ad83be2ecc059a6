//! More of it, or less: joints further from, or nearer to, the pose that the motion plays around.

use lifelike_character::{Anatomy, Character};

use super::joints::{column, columns, set_column};
use super::restyle::settle;
use super::smooth::low_pass;
use super::story::{provenance, unfit};
use crate::clip::MotionClip;
use crate::error::MotionError;
use crate::retarget::RetargetOptions;

/// Pose around which a motion is amplified.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Around {
    /// The mean pose of the clip.
    Mean,
    /// The clip itself without what is faster than this (Hz): only quick gestures are amplified, slow changes of
    /// posture stay as they are.
    LowPass(f64),
}

/// Options of amplifying.
#[derive(Debug, Clone, PartialEq)]
pub struct Amplify {
    /// Joints by name; see [`joints_of`](super::joints_of).
    pub joints: Vec<String>,
    /// By how much deviations are multiplied: above 1 is more, below 1 less, 0 none.
    pub gain: f64,
    /// Pose from which they deviate.
    pub around: Around,
}

/// Returns the clip with larger or smaller movements of some joints, within their ranges. If legs change, the soles
/// that stood are put back on the ground, and the legs kept within the speeds of `options`.
///
/// # Errors
/// [`MotionError::Unfit`] for a gain that is negative or not finite, a cutoff that is not positive, or joints that are
/// not there. [`MotionError::Mismatch`] for a clip of another character.
pub fn amplify(
    clip: &MotionClip,
    character: &Character,
    anatomy: &Anatomy,
    how: &Amplify,
    options: &RetargetOptions,
) -> Result<MotionClip, MotionError> {
    clip.check()?;
    if !(how.gain >= 0.0 && how.gain.is_finite()) {
        return Err(unfit(clip, format!("expected a gain of 0 or more, got {}", how.gain)));
    }
    let mut out = clip.clone();
    for at in columns(clip, &how.joints)? {
        let values = column(clip, at);
        let middle = match how.around {
            Around::Mean => vec![values.iter().sum::<f64>() / values.len() as f64; values.len()],
            Around::LowPass(cutoff) => low_pass(clip, &values, cutoff)?,
        };
        let scaled: Vec<f64> = values.iter().zip(&middle).map(|(v, m)| v + (how.gain - 1.0) * (v - m)).collect();
        set_column(&mut out, at, &scaled);
    }
    let around = match how.around {
        Around::Mean => "their mean".to_string(),
        Around::LowPass(cutoff) => format!("what is slower than {cutoff} Hz"),
    };
    let done = format!("'{}' with {} times {} around {around}", clip.name, how.gain, how.joints.join(", "));
    out.provenance = provenance(&[clip], done, clip.provenance.captions.clone());
    settle(clip, out, character, anatomy, options)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::fixtures::{clip, swing};
    use std::collections::BTreeMap;

    fn amplified(gain: f64, around: Around) -> Result<MotionClip, MotionError> {
        let anatomy = Anatomy { places: BTreeMap::new(), soles: BTreeMap::new() };
        let mut character = swing();
        character.joints[1].range = Some((0.0, 0.7));
        // Swings around 0.5 at 0.5 Hz, two whole periods less their last frame.
        let c = clip(200, |t| [0.5 + 0.1 * (std::f64::consts::PI * t).sin(), t]);
        let how = Amplify { joints: vec!["hinge".into()], gain, around };
        amplify(&c, &character, &anatomy, &how, &RetargetOptions::default())
    }

    #[test]
    fn deviations_from_the_mean_are_multiplied_within_the_range() {
        let out = amplified(1.5, Around::Mean).unwrap();
        assert!((out.joints_at(25)[0] - 0.65).abs() < 1e-9 && (out.joints_at(75)[0] - 0.35).abs() < 1e-9);
        assert_eq!(out.joints_at(25)[1], 0.5, "the other joint is not named");
        assert_eq!(amplified(3.0, Around::Mean).unwrap().joints_at(25)[0], 0.7, "the range ends there");
        assert!((amplified(0.0, Around::Mean).unwrap().joints_at(25)[0] - 0.5).abs() < 1e-9);
        assert!(amplified(-1.0, Around::Mean).is_err() && amplified(f64::NAN, Around::Mean).is_err());
    }

    #[test]
    fn what_is_slower_than_the_cutoff_stays() {
        // 0.5 Hz under a cutoff of 5 Hz passes almost wholly: nothing is left to amplify.
        let out = amplified(2.0, Around::LowPass(5.0)).unwrap();
        assert!((out.joints_at(75)[0] - 0.4).abs() < 2e-3, "{}", out.joints_at(75)[0]);
        assert!(amplified(2.0, Around::LowPass(0.0)).is_err());
    }
}
