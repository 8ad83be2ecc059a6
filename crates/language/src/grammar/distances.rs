//! Walks as far as was asked for: in as many steps as it takes, or in those that were counted.

use lifelike_motion::MotionClip;
use rand::Rng;

use super::draw::PartDraw;
use super::generator::Generator;
use super::perform::{LESS_EMPHASIS, MAX_CYCLES, TEMPO};
use super::spans::walked;
use crate::checks::{Tracks, measure};
use crate::error::LanguageError;

/// Lengths of a step that a distance may ask for, beside the natural one.
const STRIDE: [f64; 2] = [0.5, 1.2];
/// The same where the steps are counted, and how often their length is corrected.
const STEPS: [f64; 2] = [0.3, 3.0];
const LENGTHS: u32 = 4;
/// Times as fast from which a way in a time takes longer steps as well.
const BRISK: f64 = 1.25;

impl Generator<'_> {
    /// Walks so far (m) in the steps that were counted, as long as the legs can make them.
    pub(super) fn in_steps(
        &self,
        part: PartDraw,
        metres: f64,
        rng: &mut impl Rng,
    ) -> Result<MotionClip, LanguageError> {
        let steps = |gain: f64| self.part(&PartDraw { gain, ..part.clone() }, None);
        let (mut gain, mut most) = (1.0, STEPS[1]);
        for _ in 0..LENGTHS {
            match steps(gain) {
                Ok(clip) => {
                    let way = measure::way(&Tracks::of(&clip, self.character(), self.anatomy())?);
                    gain = (gain * metres / way.max(1e-3)).clamp(STEPS[0], most);
                }
                Err(LanguageError::Motion(_)) if gain > 1.0 => {
                    most = gain * LESS_EMPHASIS;
                    gain = most;
                }
                Err(error) => return Err(error),
            }
        }
        loop {
            match self.part(&PartDraw { gain, ..part.clone() }, Some(rng)) {
                Err(LanguageError::Motion(_)) if gain > 1.0 => gain *= LESS_EMPHASIS,
                made => return self.shortened(made?),
            }
        }
    }

    /// Walks so far (m), in as many cycles as it takes, with steps a little longer or shorter. A time that is said (s)
    /// is kept by faster and longer steps.
    pub(super) fn as_far(
        &self,
        part: PartDraw,
        metres: f64,
        seconds: Option<f64>,
        rng: &mut impl Rng,
    ) -> Result<MotionClip, LanguageError> {
        let fewest = self.grammar().verbs[part.verb].cycles.map_or(1, |[fewest, _]| fewest.max(1));
        let way = |cycles: u32| -> Result<f64, LanguageError> {
            let clip = self.part(&PartDraw { cycles, gain: 1.0, ..part.clone() }, None)?;
            Ok(measure::way(&Tracks::of(&clip, self.character(), self.anatomy())?))
        };
        let first = way(fewest)?;
        let each = (way(fewest + 1)? - first).max(1e-3);
        let in_steps = |gain: f64, part: PartDraw| {
            let more = ((metres / gain - first) / each).round().clamp(0.0, f64::from(MAX_CYCLES));
            let gain = (metres / (first + more * each)).clamp(STRIDE[0], STRIDE[1]);
            PartDraw { cycles: fewest + more as u32, gain, ..part }
        };
        let mut part = in_steps(1.0, part);
        if let Some(wanted) = seconds {
            part.speed = 1.0;
            let lasts = |part: &PartDraw| -> Result<f64, LanguageError> {
                Ok(walked(&Tracks::of(&self.part(part, None)?, self.character(), self.anatomy())?))
            };
            if lasts(&part)? > BRISK * wanted {
                part = in_steps(0.95 * STRIDE[1], part);
            }
            part.speed = (lasts(&part)? / wanted).clamp(TEMPO[0], TEMPO[1]);
        }
        self.shortened(self.part(&part, Some(rng))?)
    }
}
