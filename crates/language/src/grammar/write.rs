//! A whole data set of the grammar as a folder.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use lifelike_checkpoint::{InputError, write_file};
use lifelike_motion::container;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::generator::{Generator, Made};
use crate::dataset::{CaptionedSet, Entry, INDEX, Split};
use crate::{FromInput, LanguageError};

/// Clips that are drawn between two looks at how many hours there are.
const CHUNK: u64 = 64;
/// Draws after which there must be clips.
const TRIAL: u64 = 1024;

/// File of a data set that is being made: what to go on from.
const JOURNAL: &str = "unfinished.json";

/// Extent of a data set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Duration of all clips together (hours).
    pub hours: f64,
    /// Seed.
    pub seed: u64,
    /// Go on with the data set that is unfinished in the folder.
    pub resume: bool,
}

/// A data set that is being made, as it was after the last chunk.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Journal {
    /// Digest of grammar, robot and seed.
    origin: String,
    seconds: f64,
    summary: Summary,
    entries: Vec<Entry>,
}

impl Journal {
    /// Reads the journal to resume from, or begins one.
    fn open(folder: &Path, origin: String, resume: bool) -> Result<Self, LanguageError> {
        if !resume {
            return Ok(Self { origin, ..Self::default() });
        }
        let path = folder.join(JOURNAL);
        if !path.exists() {
            let got = match folder.join(INDEX).exists() {
                true => "a finished one: use it as it is, or make another in a new folder",
                false => "none: begin it without --resume",
            };
            return Err(LanguageError::NothingToResume { folder: folder.to_path_buf(), got });
        }
        let text = std::fs::read_to_string(&path).map_err(LanguageError::io(&path))?;
        let bad = |message: String| LanguageError::line(&path, 1, message);
        let own: Self =
            serde_json::from_str(&text).map_err(|e| bad(format!("expected an unfinished data set, got {e}")))?;
        if own.origin == origin {
            return Ok(own);
        }
        Err(bad("expected the grammar, robot and seed that the data set was begun with, got others".into()))
    }

    fn save(&self, folder: &Path) -> Result<(), LanguageError> {
        let path = folder.join(JOURNAL);
        let text = serde_json::to_vec(self).map_err(|e| LanguageError::line(&path, 1, e.to_string()))?;
        write_file(&path, &text).map_err(LanguageError::io(&path))
    }
}

/// Numbers of clips that were made and that were not.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
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
    pub splits: BTreeMap<String, f64>,
}

/// Makes clips until they reach the hours asked for and writes those that pass all checks. The result depends on the
/// grammar, the robot and the seed, not on the number of threads. `progress` gets the seconds so far; when `stop` is
/// set, finished clips are written. [`Options::resume`] goes on from there, as it does after a kill.
///
/// # Errors
/// [`LanguageError::NothingToResume`]; [`LanguageError::Input`] for a folder that cannot be written; [`LanguageError::Grammar`] when hardly a clip is true.
pub fn write(
    generator: &Generator<'_>,
    folder: &Path,
    options: &Options,
    stop: &AtomicBool,
    mut progress: impl FnMut(f64),
) -> Result<Summary, LanguageError> {
    let journal = Journal::open(folder, generator.origin(options.seed), options.resume)?;
    for split in Split::ALL {
        let path = folder.join(split.name());
        std::fs::create_dir_all(&path).map_err(LanguageError::io(&path))?;
    }
    let Journal { origin, mut seconds, mut summary, entries } = journal;
    let mut set = CaptionedSet { folder: folder.to_path_buf(), entries };
    let wanted = 3600.0 * options.hours;
    while seconds < wanted && !stop.load(Ordering::SeqCst) {
        let indices = summary.drawn..summary.drawn + CHUNK;
        let made: Vec<Result<Option<Made>, LanguageError>> =
            indices.into_par_iter().map(|index| make(generator, folder, options.seed, index)).collect();
        summary.drawn += CHUNK;
        for result in made {
            match result {
                Err(error @ LanguageError::Motion(_)) => {
                    // Written clips fail in the file system only, and that is no fault of a draw.
                    if let LanguageError::Motion(lifelike_motion::MotionError::Input(InputError::Io { .. })) = error {
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
        let (state, entries) = (summary.clone(), set.entries.clone());
        Journal { origin: origin.clone(), seconds, summary: state, entries }.save(folder)?;
    }
    set.write()?;
    summary.clips = set.entries.len();
    let captions: Vec<&String> = set.entries.iter().flat_map(|entry| &entry.captions).collect();
    summary.captions = captions.len();
    summary.different_captions = captions.iter().collect::<std::collections::BTreeSet<_>>().len();
    summary.hours = seconds / 3600.0;
    summary.splits = Split::ALL.iter().map(|split| (split.name().to_string(), set.seconds(*split) / 3600.0)).collect();
    if seconds >= wanted {
        let path = folder.join(JOURNAL);
        let _ = std::fs::remove_file(path);
    }
    Ok(summary)
}

impl Generator<'_> {
    /// Returns a digest of all that decides the clips of a seed.
    fn origin(&self, seed: u64) -> String {
        let text = format!("{:?} {} {:?} {seed}", self.grammar(), self.character().name, self.character().joints);
        Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect()
    }
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
