//! File formats as values: what is known of each, declared beside its reader, and the one table of all.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{Cursor, Read, Seek};
use std::path::Path;

use zip::ZipArchive;

use super::{FORMATS, ReadOptions};
use crate::clip::MotionClip;
use crate::error::MotionError;
use crate::source::SourceClip;

/// Bytes at the start of a file that tell its format.
const SNIFFED: u64 = 4096;

/// A file format: its names and its reader.
#[derive(Debug)]
pub struct Format {
    /// Name, as messages write it.
    pub name: &'static str,
    /// Endings of file names that are this format's alone, lower case with the dot; they decide without a look inside.
    pub suffixes: &'static [&'static str],
    /// Endings that other files have too; there the content decides.
    pub shared_suffixes: &'static [&'static str],
    /// File that must lie beside one of these, for messages; empty where none must.
    pub companion: &'static str,
    /// Names of files that end like this format's, lie among them and hold no motion: a search in folders leaves them
    /// out.
    pub not_motion: &'static [&'static str],
    /// Name of a clip where the file's own name does not tell it from others; mostly there is none.
    pub clip_name: fn(&Path) -> Option<String>,
    /// Test of a file's content.
    pub sniff: fn(&Sample) -> bool,
    /// Reader of the whole file.
    pub reader: Reader,
}

/// The part of a file's content that tells its format.
#[derive(Debug, Default)]
pub struct Sample {
    /// First bytes (white space and byte-order mark removed).
    pub start: Vec<u8>,
    /// Names of the files in a zip; none of anything else.
    pub entries: Vec<String>,
}

impl Sample {
    fn new(content: impl Read + Seek) -> Self {
        let mut content = content;
        let mut start = Vec::new();
        // A file that cannot be read has no start; its reader reports why.
        if content.by_ref().take(SNIFFED).read_to_end(&mut start).is_err() {
            return Self::default();
        }
        let is_zip = start.starts_with(b"PK\x03\x04");
        let zip = is_zip.then(|| ZipArchive::new(content).ok()).flatten();
        let entries = zip.map(|zip| zip.file_names().map(str::to_owned).collect()).unwrap_or_default();
        let text = start.strip_prefix(&[0xef, 0xbb, 0xbf]).unwrap_or(&start).trim_ascii_start();
        Self { start: text.to_vec(), entries }
    }
}

/// The reader of a format: from the file's bytes, its path (for names, messages and companions) and options.
#[derive(Debug, Clone, Copy)]
pub enum Reader {
    /// Reader of captured or written human motion, which is to be retargeted.
    Source(fn(&[u8], &Path, &ReadOptions) -> Result<SourceClip, MotionError>),
    /// Reader of motion that is already a robot's.
    Robot(fn(&[u8], &Path, &ReadOptions) -> Result<MotionClip, MotionError>),
}

impl Format {
    /// Returns whether a file's name alone says that it has this format.
    pub fn is_named(&self, path: &Path) -> bool {
        ending_of(path, self.suffixes).is_some()
    }

    /// Returns whether it holds human motion, and this content is of it.
    pub(super) fn is_source_of(&self, content: &[u8]) -> bool {
        self.is_source() && (self.sniff)(&Sample::new(Cursor::new(content)))
    }

    /// Returns whether it holds human motion, which is to be retargeted.
    pub fn is_source(&self) -> bool {
        matches!(self.reader, Reader::Source(_))
    }
}

/// Returns the format of a file that somebody named: its ending decides, and the content where the ending says nothing.
pub fn of_file(path: &Path) -> Option<&'static Format> {
    by_claim(path, || sample_of(path)).or_else(|| by_name(path)).or_else(|| by_sample(&sample_of(path)))
}

/// Returns the format of a file that was found in a folder. Only files whose ending some format has are looked at:
/// notes end in `.txt` as DeepMimic's motions do.
pub fn of_found(path: &Path) -> Option<&'static Format> {
    let name = path.file_name()?.to_string_lossy().to_ascii_lowercase();
    if FORMATS.iter().any(|format| format.not_motion.contains(&name.as_str())) {
        return None;
    }
    by_claim(path, || sample_of(path)).or_else(|| by_name(path))
}

/// Returns a clip's name by its file: the format's own name for it, the file's without the format's ending, or else
/// without extension.
pub fn clip_name(path: &Path) -> String {
    if let Some(name) = by_name(path).and_then(|format| (format.clip_name)(path)) {
        return name;
    }
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let ending = FORMATS.iter().find_map(|format| ending_of(path, format.suffixes));
    let stem = match ending {
        Some(ending) => name.get(..name.len() - ending.len()).map(str::to_owned),
        None => path.file_stem().map(|stem| stem.to_string_lossy().into_owned()),
    };
    stem.filter(|stem| !stem.is_empty()).unwrap_or_else(|| "clip".to_owned())
}

/// Returns the formats as messages and help texts list them: names, endings and what must lie beside a file.
pub fn supported(accepts: impl Fn(&Format) -> bool) -> String {
    let mut text = String::new();
    for format in FORMATS.iter().copied().filter(|format| accepts(format)) {
        let endings = [format.suffixes, format.shared_suffixes].concat().join(", ");
        let comma = if text.is_empty() { "" } else { ", " };
        let beside = if format.companion.is_empty() { String::new() } else { format!(" with {}", format.companion) };
        // Writing to a string cannot fail.
        let _ = write!(text, "{comma}{} ({endings}{beside})", format.name);
    }
    text
}

/// Returns the format of a file whose whole content is here.
pub(crate) fn of_content(path: &Path, bytes: &[u8]) -> Option<&'static Format> {
    let sample = || Sample::new(Cursor::new(bytes));
    by_claim(path, sample).or_else(|| by_name(path)).or_else(|| by_sample(&sample()))
}

/// Returns the format that has a file's ending, with others, and its content.
fn by_claim(path: &Path, sample: impl Fn() -> Sample) -> Option<&'static Format> {
    let shares = |format: &&&Format| ending_of(path, format.shared_suffixes).is_some();
    FORMATS.iter().find(shares)?;
    let sample = sample();
    FORMATS.iter().filter(shares).copied().find(|format| (format.sniff)(&sample))
}

/// Returns the format that content itself tells.
fn by_sample(sample: &Sample) -> Option<&'static Format> {
    FORMATS.iter().copied().find(|format| (format.sniff)(sample))
}

fn by_name(path: &Path) -> Option<&'static Format> {
    FORMATS.iter().copied().find(|format| format.is_named(path))
}

/// Returns the one of these endings that a file's name has, in capitals or not.
fn ending_of(path: &Path, endings: &[&'static str]) -> Option<&'static str> {
    let name = path.file_name()?.to_string_lossy().to_ascii_lowercase();
    endings.iter().find(|ending| name.ends_with(*ending)).copied()
}

fn sample_of(path: &Path) -> Sample {
    File::open(path).map(Sample::new).unwrap_or_default()
}
