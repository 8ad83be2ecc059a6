//! Values of many items (the clips of a tracker) at a few moments of a run: one line a snapshot, the items' names only once.

use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use crate::{FromInput, ReportError};

/// Digits after the point that a snapshot keeps: it is for looking at, and a run goes on from its checkpoint.
const SCALE: f64 = 1e4;

/// Values of many items at one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshot {
    /// Names of the items: the same in all snapshots of a run.
    pub items: Vec<String>,
    /// Columns by name, a value for each item; what is not finite becomes `null`.
    pub columns: Vec<(&'static str, Vec<f64>)>,
}

/// Appends to `snapshots.jsonl`.
#[derive(Debug)]
pub struct SnapshotWriter {
    path: PathBuf,
    file: Option<File>,
    bytes: u64,
}

impl SnapshotWriter {
    /// Continues a file after so many bytes; whatever stands behind them never happened.
    ///
    /// # Errors
    /// [`ReportError::Input`] when the file is shorter: it is not the file of that run.
    pub(super) fn resume(path: &Path, position: u64) -> Result<Self, ReportError> {
        let mut writer = Self { path: path.to_path_buf(), file: None, bytes: position };
        if !path.exists() && position == 0 {
            // The file of a run without items is never made.
            return Ok(writer);
        }
        let file =
            OpenOptions::new().create(true).truncate(false).write(true).open(path).map_err(ReportError::io(path))?;
        let length = file.metadata().map_err(ReportError::io(path))?.len();
        if length < position {
            let expected = format!("at least the {position} bytes that the checkpoint remembers");
            return Err(ReportError::format(path.display(), expected, format!("{length} bytes")));
        }
        file.set_len(position).and_then(|()| file.sync_all()).map_err(ReportError::io(path))?;
        drop(file);
        writer.open()?;
        Ok(writer)
    }

    fn open(&mut self) -> Result<&mut File, ReportError> {
        let file = match self.file.take() {
            Some(file) => file,
            None => {
                OpenOptions::new().create(true).append(true).open(&self.path).map_err(ReportError::io(&self.path))?
            }
        };
        Ok(self.file.insert(file))
    }

    /// Writes a snapshot, after the items' names where it is the first.
    ///
    /// # Errors
    /// [`ReportError::Input`].
    pub fn write(&mut self, iteration: u64, snapshot: &Snapshot) -> Result<(), ReportError> {
        let mut text = String::new();
        if self.bytes == 0 {
            text += &format!("{}\n", json!({ "items": snapshot.items }));
        }
        let mut line = Map::new();
        line.insert("iteration".into(), iteration.into());
        for (name, values) in &snapshot.columns {
            let rounded = values.iter().map(|value| Value::from((value * SCALE).round() / SCALE));
            line.insert((*name).into(), rounded.collect());
        }
        text += &format!("{}\n", Value::Object(line));
        let written = self.open()?.write_all(text.as_bytes());
        written.map_err(ReportError::io(&self.path))?;
        self.bytes += text.len() as u64;
        Ok(())
    }

    /// Makes sure that the file is on the disk, and returns its length (bytes): what a checkpoint remembers.
    ///
    /// # Errors
    /// [`ReportError::Input`].
    pub fn sync(&mut self) -> Result<u64, ReportError> {
        if let Some(file) = &self.file {
            file.sync_all().map_err(ReportError::io(&self.path))?;
        }
        Ok(self.bytes)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn names_stand_once_and_what_followed_a_checkpoint_is_cut_off() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("snapshots.jsonl");
        let snapshot = |seen: f64| Snapshot {
            items: vec!["walk".into(), "nod \"x\"".into()],
            columns: vec![("survival", vec![f64::NAN, 0.123_456]), ("seen", vec![1.0, seen])],
        };
        let mut writer = SnapshotWriter::resume(&path, 0).unwrap();
        assert_eq!(writer.sync().unwrap(), 0);
        assert!(!path.exists(), "a run without items has no such file");
        writer.write(1, &snapshot(0.25)).unwrap();
        let position = writer.sync().unwrap();
        writer.write(2, &snapshot(0.5)).unwrap();
        SnapshotWriter::resume(&path, position).unwrap().write(3, &snapshot(0.75)).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert_eq!(lines[0], json!({ "items": ["walk", "nod \"x\""] }));
        assert_eq!(lines[1], json!({ "iteration": 1, "survival": [null, 0.1235], "seen": [1.0, 0.25] }));
        assert_eq!((lines.len(), &lines[2]["iteration"]), (3, &json!(3)));
        assert!(SnapshotWriter::resume(&path, 1 << 20).is_err(), "a position beyond the end is another run's");
    }
}
