//! Captioned motions from a data set's folder.

use lifelike_language::{CaptionedSet, Split};
use rayon::prelude::*;

use super::data::{CaptionedMotion, EvaluatorData};
use crate::GenerationError;
use crate::representation::{FeatureMatrix, RepresentationSpec};

impl CaptionedMotion {
    /// Reads the clips of a split, in the index's order.
    ///
    /// # Errors
    /// A clip that cannot be read or that has other joints than the spec's.
    pub fn read(set: &CaptionedSet, split: Split, spec: &RepresentationSpec) -> Result<Vec<Self>, GenerationError> {
        let entries: Vec<_> = set.of(split).collect();
        let read = |entry: &&lifelike_language::Entry| {
            let motion = FeatureMatrix::from_clip(&set.clip(entry)?, spec)?;
            Ok(Self { motion, captions: entry.captions.clone() })
        };
        entries.par_iter().map(read).collect()
    }
}

impl EvaluatorData {
    /// Reads the training and validation motions of a data set.
    ///
    /// # Errors
    /// As [`CaptionedMotion::read`].
    pub fn read(set: &CaptionedSet, spec: &RepresentationSpec) -> Result<Self, GenerationError> {
        let of = |split| CaptionedMotion::read(set, split, spec);
        Ok(Self { training: of(Split::Train)?, validation: of(Split::Validation)? })
    }
}
