//! Captions of captured clips: tables of tab-separated values, one row per clip.
//!
//! Two layouts are known by their header: `trial, ..., trial_description, ..., kitml_captions` (captions as a JSON list of
//! `[start s, end s, text]`), and `file, content, style, ..., seconds`.

use std::collections::BTreeMap;
use std::path::Path;

use super::{clip_name, text};
use crate::clip::Caption;
use crate::error::MotionError;

/// A sentence, with its stretch of the clip where that is known.
type Entry = (Option<[f64; 2]>, String);

/// Captions by clip name.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CaptionTable {
    by_name: BTreeMap<String, Vec<Entry>>,
}

impl CaptionTable {
    /// Reads a table.
    ///
    /// # Errors
    /// [`MotionError::Input`] for a file that cannot be read, [`MotionError::Parse`] with the line for one that is neither
    /// layout.
    pub fn load(path: &Path) -> Result<Self, MotionError> {
        Self::parse(&text::read_bytes(path)?, path)
    }

    /// Reads a table from memory. `file` is for messages only.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn parse(bytes: &[u8], file: &Path) -> Result<Self, MotionError> {
        let mut lines = text::Lines::new(text::decode(bytes, file)?, file);
        let header = cells(lines.expect("a header")?);
        let column = |name: &str| header.iter().position(|h| h == name);
        let mut table = Self::default();
        let kit = (column("trial"), column("trial_description"), column("kitml_captions"));
        let styles = (column("file"), column("content"), column("style"));
        while let Some(line) = lines.next_line() {
            let row = cells(line);
            let cell = |at: usize| row.get(at).map(String::as_str).ok_or_else(|| lines.error("all columns", line));
            let (name, entries) = match (kit, styles) {
                ((Some(trial), Some(description), captions), _) => {
                    let mut entries: Vec<Entry> = vec![(None, cell(description)?.to_owned())];
                    if let Some(captions) = captions {
                        let list: Vec<(f64, f64, String)> = serde_json::from_str(cell(captions)?)
                            .map_err(|e| lines.error("a JSON list of [start, end, text]", &e.to_string()))?;
                        entries.extend(list.into_iter().map(|(start, end, text)| (Some([start, end]), text)));
                    }
                    (cell(trial)?.to_owned(), entries)
                }
                (_, (Some(path), Some(content), Some(style))) => {
                    let said = format!("{}, {}", cell(content)?.replace('-', " "), cell(style)?.replace('-', " "));
                    (clip_name(Path::new(cell(path)?)), vec![(None, said)])
                }
                _ => return Err(lines.error("columns 'trial, trial_description' or 'file, content, style'", line)),
            };
            table.by_name.entry(name).or_default().extend(entries);
        }
        Ok(table)
    }

    /// Returns the captions of a clip of this length (s), by its file's name.
    pub fn find(&self, path: &Path, seconds: f64) -> Vec<Caption> {
        let entries = self.by_name.get(&clip_name(path)).map(Vec::as_slice).unwrap_or_default();
        let whole = [0.0, seconds];
        entries
            .iter()
            .filter(|(_, text)| !text.is_empty())
            .map(|(stretch, text)| {
                let [start, end] = stretch.unwrap_or(whole);
                Caption { start, end, text: text.clone() }
            })
            .collect()
    }
}

/// Returns the cells between tabs; a cell in quotation marks may hold tabs, and doubled marks stand for one.
fn cells(line: &str) -> Vec<String> {
    let mut cells = vec![String::new()];
    let (mut quoted, mut chars) = (false, line.chars().peekable());
    while let Some(c) = chars.next() {
        let Some(cell) = cells.last_mut() else { break };
        match c {
            '"' if quoted && chars.peek() == Some(&'"') => {
                chars.next();
                cell.push('"');
            }
            '"' if quoted => quoted = false,
            '"' if cell.is_empty() => quoted = true,
            '\t' if !quoted => cells.push(String::new()),
            _ => cell.push(c),
        }
    }
    cells
}
