//! Ability of an evaluator to tell motions apart that it has not learned from: the upper bound of any method's scores.

use super::data::caption_kinds;
use super::file::Evaluator;
use crate::GenerationError;
use crate::data::CaptionedMotion;
use crate::metrics::{Sample, Scores};
use crate::representation::FeatureMatrix;

impl Evaluator {
    /// Embeds motions and their first sentences.
    ///
    /// # Errors
    /// A motion or sentence that does not fit.
    pub fn sample(&self, items: &[CaptionedMotion]) -> Result<Sample, GenerationError> {
        let captions: Vec<&str> = items.iter().filter_map(|item| item.captions.first()).map(String::as_str).collect();
        let motions: Vec<FeatureMatrix> = items.iter().map(|item| item.rows.clone()).collect();
        Ok(Sample {
            text: self.sentences(&captions)?,
            motion: self.motions(&motions)?,
            kinds: caption_kinds(captions),
            repeated: None,
        })
    }

    /// Measures motions under their first sentences, `repetitions` times with other pools; none where there are fewer
    /// than two different sentences.
    ///
    /// # Errors
    /// As [`Self::sample`].
    pub fn scores(
        &self,
        items: &[CaptionedMotion],
        repetitions: u64,
        seed: u64,
    ) -> Result<Option<Scores>, GenerationError> {
        let sample = self.sample(items)?;
        Scores::of(None, repetitions, seed, |_| Ok(sample.clone()))
    }
}
