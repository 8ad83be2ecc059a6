//! Captioned clips as a folder: `*.motion.safetensors` and an index, `dataset.jsonl`, a JSON object per line.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use lifelike_checkpoint::write_file;
use lifelike_motion::{MotionClip, container};
use serde::{Deserialize, Serialize};

use crate::facts::Facts;
use crate::{FromInput, LanguageError};

/// The index's file name.
pub const INDEX: &str = "dataset.jsonl";

/// A part of a data set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Split {
    /// Trained on.
    Train,
    /// For choosing while training.
    Validation,
    /// Unseen motion of kinds that were seen.
    Test,
    /// Combinations or words never trained on.
    HeldOut,
}

impl Split {
    /// Every split.
    pub const ALL: [Self; 4] = [Self::Train, Self::Validation, Self::Test, Self::HeldOut];

    /// Returns the name, as it stands in the index.
    pub fn name(self) -> &'static str {
        match self {
            Self::Train => "train",
            Self::Validation => "validation",
            Self::Test => "test",
            Self::HeldOut => "held_out",
        }
    }
}

/// One clip of a data set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// The clip's file, relative to the folder.
    pub file: String,
    /// The split.
    pub split: Split,
    /// Duration (s).
    pub seconds: f64,
    /// Sentences that are true of the whole clip.
    pub captions: Vec<String>,
    /// Origin: a data set's name, and the clip there.
    pub source: String,
    /// Terms of use.
    pub licence: String,
    /// Facts that the captions promise; none where nothing can be checked.
    pub facts: Option<Facts>,
}

/// The index of a folder of captioned clips.
#[derive(Debug, Clone, PartialEq)]
pub struct CaptionedSet {
    /// The folder.
    pub folder: PathBuf,
    /// Every clip, in the index's order.
    pub entries: Vec<Entry>,
}

impl CaptionedSet {
    /// Reads the index of a folder. Clips are read by [`Self::clip`].
    ///
    /// # Errors [`LanguageError::Input`] for a folder without index; [`LanguageError::Line`] for a line that is no entry,
    /// an entry without caption and a duration that is not positive. It is returned as well for a file outside of the
    /// folder or named twice, and one motion file in two splits.
    pub fn read(folder: &Path) -> Result<Self, LanguageError> {
        let path = folder.join(INDEX);
        let text = std::fs::read_to_string(&path).map_err(LanguageError::io(&path))?;
        Ok(Self { folder: folder.to_path_buf(), entries: parse(&text, &path)? })
    }

    /// Writes the index.
    ///
    /// # Errors
    /// [`LanguageError::Input`] for a folder that cannot be written, [`LanguageError::Line`] for an entry that
    /// [`Self::read`] would refuse.
    pub fn write(&self) -> Result<(), LanguageError> {
        let path = self.folder.join(INDEX);
        let mut text = String::new();
        for (at, entry) in self.entries.iter().enumerate() {
            let line = serde_json::to_string(entry).map_err(|e| {
                LanguageError::line(&path, at + 1, format!("expected an entry that can be written: {e}"))
            })?;
            text += &line;
            text.push('\n');
        }
        parse(&text, &path)?;
        write_file(&path, text.as_bytes()).map_err(LanguageError::io(&path))
    }

    /// Returns the entries of a split.
    pub fn of(&self, split: Split) -> impl Iterator<Item = &Entry> {
        self.entries.iter().filter(move |entry| entry.split == split)
    }

    /// Reads the clip of an entry.
    ///
    /// # Errors
    /// As [`container::read`].
    pub fn clip(&self, entry: &Entry) -> Result<MotionClip, LanguageError> {
        Ok(container::read(&self.folder.join(&entry.file))?)
    }

    /// Returns the duration of a split (s).
    pub fn seconds(&self, split: Split) -> f64 {
        // A sum of nothing would be -0.
        self.of(split).fold(0.0, |sum, entry| sum + entry.seconds)
    }
}

fn parse(text: &str, path: &Path) -> Result<Vec<Entry>, LanguageError> {
    let mut files = BTreeSet::new();
    let mut entries = Vec::new();
    for (at, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let bad = |message: String| LanguageError::line(path, at + 1, message);
        let entry: Entry = serde_json::from_str(line).map_err(|e| bad(format!("expected an entry, got {e}")))?;
        if !(entry.seconds.is_finite() && entry.seconds > 0.0) {
            return Err(bad(format!("expected a positive number of seconds, got {}", entry.seconds)));
        }
        if entry.captions.is_empty() || entry.captions.iter().any(|caption| caption.trim().is_empty()) {
            return Err(bad("expected at least one caption and none of them empty".into()));
        }
        let inside = Path::new(&entry.file).components().all(|c| matches!(c, std::path::Component::Normal(_)));
        if entry.file.is_empty() || !inside {
            return Err(bad(format!("expected a file inside of the folder, got '{}'", entry.file)));
        }
        if !files.insert(entry.file.clone()) {
            return Err(bad(format!("expected every file once, got '{}' again", entry.file)));
        }
        entries.push(entry);
    }
    Ok(entries)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn entry(file: &str) -> Entry {
        Entry {
            file: file.into(),
            split: Split::HeldOut,
            seconds: 2.5,
            captions: vec!["a person waves".into()],
            source: "x".into(),
            licence: "CC0".into(),
            facts: None,
        }
    }

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let set = CaptionedSet { folder: folder.path().into(), entries: vec![entry("a"), entry("b/c")] };
        set.write().unwrap();
        assert_eq!(CaptionedSet::read(folder.path()).unwrap(), set);
        assert_eq!((set.seconds(Split::HeldOut), set.of(Split::Train).count()), (5.0, 0));
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        let folder = tempfile::tempdir().unwrap();
        let good = serde_json::to_string(&entry("a")).unwrap();
        let cases = [
            (good.clone(), "again"),
            (good.replace("\"a\"", "\"../a\""), "inside"),
            (good.replace("2.5", "0"), "positive"),
            (good.replace("a person waves", " "), "caption"),
            (good.replace("held_out", "exam"), "exam"),
            ("{".into(), "expected"),
        ];
        for (line, part) in cases {
            std::fs::write(folder.path().join(INDEX), format!("{good}\n{line}\n")).unwrap();
            let message = CaptionedSet::read(folder.path()).unwrap_err().to_string();
            assert!(message.contains("dataset.jsonl:2:") && message.contains(part), "{message}");
        }
        assert!(CaptionedSet::read(&folder.path().join("none")).unwrap_err().to_string().contains("none"));
    }
}
