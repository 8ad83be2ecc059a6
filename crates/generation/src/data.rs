//! Captioned motion of one robot: what generators learn from and are aligned on, and what evaluators compare.

use std::path::PathBuf;

use lifelike_language::dataset::INDEX;
use lifelike_language::{CaptionedSet, Entry, Split};
use lifelike_motion::MotionClip;
use lifelike_robot::{Robot, clips};
use rayon::prelude::*;

use crate::representation::{FeatureMatrix, RepresentationSpec};
use crate::{FromInput, GenerationError};

/// Rows below which there is no motion to learn from.
const MIN_ROWS: usize = 10;

/// One motion with its captions.
#[derive(Debug, Clone, PartialEq)]
pub struct CaptionedMotion {
    /// Name, for messages.
    pub name: String,
    /// Use.
    pub split: Split,
    /// The motion, in SI units.
    pub rows: FeatureMatrix,
    /// Sentences that are true of all of it, one or more.
    pub captions: Vec<String>,
    /// Terms of use.
    pub licence: String,
}

impl CaptionedMotion {
    /// Reads the clips of some entries of a data set, in their order.
    ///
    /// # Errors
    /// A clip that cannot be read or that has other joints than the spec's.
    pub fn read<'a>(
        set: &CaptionedSet,
        entries: impl IntoIterator<Item = &'a Entry>,
        spec: &RepresentationSpec,
    ) -> Result<Vec<Self>, GenerationError> {
        let read = |entry: &Entry| {
            let clip = set.clip(entry)?;
            let (rows, captions) = (FeatureMatrix::from_clip(&clip, spec)?, entry.captions.clone());
            Ok(Self { name: clip.name, split: entry.split, rows, captions, licence: entry.licence.clone() })
        };
        entries.into_iter().collect::<Vec<_>>().into_par_iter().map(read).collect()
    }

    /// Returns the motions of folders with an index and of other clips, cut off after this duration. Within each input
    /// they are in the order of their names.
    ///
    /// # Errors
    /// A file that cannot be read, a line of an index that is none, or no motion at all.
    pub fn load(inputs: &[PathBuf], robot: &Robot, max_seconds: f64) -> Result<Vec<Self>, GenerationError> {
        let spec = RepresentationSpec::of(&robot.layout);
        let mut out = Vec::new();
        for input in inputs {
            if input.join(INDEX).is_file() {
                let set = CaptionedSet::read(input)?;
                out.extend(Self::read(&set, &set.entries, &spec)?);
                continue;
            }
            for clip in clips::load(std::slice::from_ref(input), robot)?.all()? {
                let rows = FeatureMatrix::from_clip(&clip, &spec)?;
                let (captions, licence) = (captions(&clip), clip.provenance.licence);
                out.push(Self { name: clip.name, split: Split::Train, rows, captions, licence });
            }
        }
        for rows in out.iter_mut().map(|motion| &mut motion.rows) {
            rows.n = rows.n.min((max_seconds * spec.fps).round() as usize + 1);
            rows.rows.truncate(rows.n * rows.width);
        }
        out.retain(|motion| motion.rows.n >= MIN_ROWS && !motion.captions.is_empty());
        if out.iter().any(|motion| motion.split == Split::Train) {
            return Ok(out);
        }
        Err(GenerationError::mismatch(
            "captioned motion to train on",
            format!("at least one of {MIN_ROWS} rows"),
            "none",
        ))
    }
}

/// Returns the sentences of a clip's container, or its name as words.
fn captions(clip: &MotionClip) -> Vec<String> {
    let own: Vec<String> = clip.provenance.captions.iter().map(|caption| caption.text.clone()).collect();
    if own.is_empty() { vec![clip.name.replace(['_', '-', '+', '.'], " ")] } else { own }
}
