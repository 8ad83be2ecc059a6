//! A whole data set of the grammar as a folder.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use lifelike_motion::container;
use rayon::prelude::*;
use serde::Serialize;

use super::generator::{Generator, Made};
use crate::dataset::{CaptionedSet, Split};
use crate::error::LanguageError;

/// Clips that are drawn between two looks at how many hours there are.
const CHUNK: u64 = 64;
/// Draws after which there must be clips.
const TRIAL: u64 = 1024;

/// Extent of a data set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Duration of all clips together (hours).
    pub hours: f64,
    /// Seed.
    pub seed: u64,
}

/// What was made, and what was not.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Summary {
    /// Clips.
    pub clips: usize,
    /// Captions.
    pub captions: usize,
    /// Different captions.
    pub different_captions: usize,
    /// Duration (hours).
    pub hours: f64,
    /// Draws.
    pub drawn: u64,
    /// Draws that would have been too short or too long.
    pub unsuitable: usize,
    /// Clips that were made and checked.
    pub made: usize,
    /// Draws that could not be made, by reason.
    pub failed: BTreeMap<String, usize>,
    /// Clips that were dropped because a check failed, by verb and fact.
    pub untrue: BTreeMap<String, usize>,
    /// Clips dropped because a check failed.
    pub dropped: usize,
    /// Hours of each split.
    pub splits: BTreeMap<&'static str, f64>,
}

/// Makes clips until they reach the hours asked for and writes those that pass all checks. The result depends on the grammar,
/// the robot and the seed, not on the number of threads. `progress` gets the seconds so far; when `stop` is set, what
/// is done is written.
///
/// # Errors
/// [`LanguageError::Io`] for a folder that cannot be written; [`LanguageError::Grammar`] when hardly a clip is true.
pub fn write(
    generator: &Generator<'_>,
    folder: &Path,
    options: &Options,
    stop: &AtomicBool,
    mut progress: impl FnMut(f64),
) -> Result<Summary, LanguageError> {
    for split in Split::ALL {
        let path = folder.join(split.name());
        std::fs::create_dir_all(&path).map_err(LanguageError::io(&path))?;
    }
    let mut set = CaptionedSet { folder: folder.to_path_buf(), entries: Vec::new() };
    let mut summary = Summary::default();
    let (mut seconds, wanted) = (0.0, 3600.0 * options.hours);
    while seconds < wanted && !stop.load(Ordering::SeqCst) {
        let indices = summary.drawn..summary.drawn + CHUNK;
        let made: Vec<Result<Option<Made>, LanguageError>> =
            indices.into_par_iter().map(|index| make(generator, folder, options.seed, index)).collect();
        summary.drawn += CHUNK;
        for result in made {
            match result {
                Err(error @ LanguageError::Motion(_)) => {
                    // Written clips fail in the file system only, and that is no fault of a draw.
                    if let LanguageError::Motion(lifelike_motion::MotionError::Io { .. }) = error {
                        return Err(error);
                    }
                    *summary.failed.entry(reason(&error)).or_default() += 1;
                }
                Err(error) => return Err(error),
                Ok(None) => summary.unsuitable += 1,
                Ok(Some(made)) if !made.is_true() => {
                    summary.made += 1;
                    summary.dropped += 1;
                    for finding in made.findings.iter().filter(|finding| !finding.passed) {
                        *summary.untrue.entry(format!("{} {}", finding.verb, finding.fact.name())).or_default() += 1;
                    }
                }
                Ok(Some(made)) => {
                    summary.made += 1;
                    if seconds < wanted {
                        seconds += made.entry.seconds;
                        set.entries.push(made.entry);
                    } else {
                        let path = folder.join(&made.entry.file);
                        std::fs::remove_file(&path).map_err(LanguageError::io(&path))?;
                    }
                }
            }
        }
        if summary.drawn >= TRIAL && set.entries.len() < summary.drawn as usize / 20 {
            let message =
                format!("expected most clips to pass their checks, got {} of {}", set.entries.len(), summary.drawn);
            return Err(LanguageError::Grammar(message));
        }
        progress(seconds);
    }
    set.write()?;
    summary.clips = set.entries.len();
    let captions: Vec<&String> = set.entries.iter().flat_map(|entry| &entry.captions).collect();
    summary.captions = captions.len();
    summary.different_captions = captions.iter().collect::<std::collections::BTreeSet<_>>().len();
    summary.hours = seconds / 3600.0;
    summary.splits = Split::ALL.iter().map(|split| (split.name(), set.seconds(*split) / 3600.0)).collect();
    Ok(summary)
}

/// Makes clip `index` and writes it where it is true.
fn make(generator: &Generator<'_>, folder: &Path, seed: u64, index: u64) -> Result<Option<Made>, LanguageError> {
    let Some(drawn) = generator.draw(seed, index) else { return Ok(None) };
    let made = generator.make(&drawn, seed)?;
    if let Some(made) = made.as_ref().filter(|made| made.is_true()) {
        container::write(&folder.join(&made.entry.file), &made.clip)?;
    }
    Ok(made)
}

/// Returns the reason of a failure without its numbers, so that alike ones are one.
fn reason(error: &LanguageError) -> String {
    error.to_string().chars().filter(|c| !c.is_ascii_digit() && *c != '.').collect()
}
