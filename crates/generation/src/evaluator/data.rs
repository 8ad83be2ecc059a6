//! Data of an evaluator.

use std::collections::BTreeMap;

use lifelike_language::{CaptionedSet, Split};
use sha2::{Digest, Sha256};

use crate::data::CaptionedMotion;
use crate::representation::RepresentationSpec;
use crate::text::prompt;
use crate::{FromInput, GenerationError};

/// Motions to learn from, and motions to choose by.
#[derive(Debug, Clone, PartialEq)]
pub struct EvaluatorData {
    /// Learned from.
    pub training: Vec<CaptionedMotion>,
    /// The best networks are chosen by these; may be empty.
    pub validation: Vec<CaptionedMotion>,
}

impl EvaluatorData {
    /// Reads the training and validation motions of a data set.
    ///
    /// # Errors
    /// As [`CaptionedMotion::read`].
    pub fn read(set: &CaptionedSet, spec: &RepresentationSpec) -> Result<Self, GenerationError> {
        let of = |split| CaptionedMotion::read(set, set.of(split), spec);
        Ok(Self { training: of(Split::Train)?, validation: of(Split::Validation)? })
    }

    /// Checks that there are motions of one width, each with a sentence that can be read.
    pub(super) fn check(&self) -> Result<(), GenerationError> {
        let width = self.training.first().map_or(0, |first| first.rows.width);
        if self.training.len() < 2 {
            return Err(GenerationError::mismatch("motions to train on", "two or more", self.training.len()));
        }
        for item in self.training.iter().chain(&self.validation) {
            if item.rows.width != width {
                return Err(GenerationError::mismatch("width of a motion", width, item.rows.width));
            }
            if item.rows.n == 0 || item.captions.is_empty() {
                let got = format!("{} rows, {} sentences", item.rows.n, item.captions.len());
                return Err(GenerationError::mismatch("a captioned motion", "rows and a sentence", got));
            }
            item.captions.iter().try_for_each(|caption| prompt::check(caption).map(|_| ()))?;
        }
        Ok(())
    }

    /// Returns a digest of everything that is learned from.
    pub(super) fn digest(&self) -> String {
        let mut hash = Sha256::new();
        for item in &self.training {
            hash.update((item.rows.n as u64).to_le_bytes());
            item.rows.rows.iter().for_each(|x| hash.update(x.to_le_bytes()));
            for caption in &item.captions {
                hash.update((caption.len() as u64).to_le_bytes());
                hash.update(caption.as_bytes());
            }
        }
        let digest: String = hash.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect();
        format!("{} motions, digest {digest}", self.training.len())
    }
}

/// Returns a number for every sentence, the same for sentences of the same words.
pub fn caption_kinds<'a>(captions: impl IntoIterator<Item = &'a str>) -> Vec<usize> {
    let mut known: BTreeMap<Vec<String>, usize> = BTreeMap::new();
    let mut kinds = Vec::new();
    for caption in captions {
        let next = known.len();
        kinds.push(*known.entry(prompt::words(caption)).or_insert(next));
    }
    kinds
}
