//! The file: written beside its place, synced, renamed; read back only when its digest fits.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::{Path, PathBuf};

use safetensors::{Dtype, SafeTensors, View};
use sha2::{Digest, Sha256};

use super::{Checkpoint, CheckpointError, Entry, Kind};
use crate::FromInput;

/// The one metadata key we write. A single key keeps the file's bytes reproducible: the safetensors writer takes its
/// metadata from a hash map, whose order is random.
const KEY: &str = "lifelike";
/// That of a motion.
const MOTION: &str = "motion";

#[derive(serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    format: u32,
    sha256: String,
    /// JSON in JSON: the digest is over this very text. Numbers that are parsed and written again may differ in the last
    /// digit.
    metadata: String,
}

struct Raw<'a> {
    entry: &'a Entry,
    bytes: Vec<u8>,
}

impl View for &Raw<'_> {
    fn dtype(&self) -> Dtype {
        match self.entry.kind() {
            Kind::F32 => Dtype::F32,
            Kind::F64 => Dtype::F64,
            Kind::U64 => Dtype::U64,
            Kind::U8 => Dtype::U8,
        }
    }
    fn shape(&self) -> &[usize] {
        self.entry.shape()
    }
    fn data(&self) -> std::borrow::Cow<'_, [u8]> {
        self.bytes.as_slice().into()
    }
    fn data_len(&self) -> usize {
        self.bytes.len()
    }
}

impl Checkpoint {
    /// Returns the file's bytes: the same for equal contents, always.
    ///
    /// # Errors
    /// The contents cannot be serialised.
    pub fn to_bytes(&self) -> Result<Vec<u8>, CheckpointError> {
        let raw: BTreeMap<&String, Raw<'_>> =
            self.entries.iter().map(|(n, entry)| (n, Raw { entry, bytes: entry.to_bytes() })).collect();
        let fail = |why: String| CheckpointError::Format { path: PathBuf::from(&self.origin), why };
        let metadata = serde_json::to_string(&self.metadata).map_err(|e| fail(e.to_string()))?;
        let sha256 = digest(raw.iter().map(|(n, r)| (n.as_str(), r.entry, r.bytes.as_slice())), &metadata);
        let header = serde_json::to_string(&Header { format: 1, sha256, metadata }).map_err(|e| fail(e.to_string()))?;
        let header = Some(HashMap::from([(KEY.to_owned(), header)]));
        safetensors::serialize(raw.iter(), header).map_err(|e| fail(e.to_string()))
    }

    /// Writes the checkpoint as [`write_file`](crate::write_file) does: a reader finds the old file or the new one, whole.
    ///
    /// # Errors
    /// The folder does not exist or cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), CheckpointError> {
        crate::write_file(path, &self.to_bytes()?).map_err(CheckpointError::io(path))
    }

    /// Reads a checkpoint.
    ///
    /// # Errors
    /// Precisely what is wrong: a file cut off, one that is no checkpoint, or one whose contents changed.
    pub fn load(path: &Path) -> Result<Self, CheckpointError> {
        let bytes = fs::read(path).map_err(CheckpointError::io(path))?;
        Self::from_bytes(&bytes, path)
    }

    /// As [`Self::load`], from bytes; `path` is for messages.
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Self, CheckpointError> {
        let fail = |why: String| CheckpointError::Format { path: path.to_path_buf(), why };
        check_length(bytes, path)?;
        let (_, info) = SafeTensors::read_metadata(bytes).map_err(|e| fail(e.to_string()))?;
        let tensors = SafeTensors::deserialize(bytes).map_err(|e| fail(e.to_string()))?;
        let header = info.metadata().as_ref().and_then(|m| m.get(KEY)).ok_or_else(|| {
            match info.metadata().as_ref().is_some_and(|m| m.contains_key(MOTION)) {
                true => fail("a motion, where a network is expected".to_owned()),
                false => fail(format!("no {KEY:?} metadata: another program wrote this safetensors file")),
            }
        })?;
        let header: Header = serde_json::from_str(header).map_err(|e| fail(format!("metadata: {e}")))?;
        if header.format != 1 {
            return Err(fail(format!("format {}, this program reads format 1", header.format)));
        }
        let mut entries = BTreeMap::new();
        for (name, view) in tensors.iter() {
            let kind = match view.dtype() {
                Dtype::F32 => Kind::F32,
                Dtype::F64 => Kind::F64,
                Dtype::U64 => Kind::U64,
                Dtype::U8 => Kind::U8,
                other => return Err(fail(format!("{name}: unsupported type {other:?}"))),
            };
            entries.insert(name.to_owned(), Entry::from_bytes(kind, view.shape().to_vec(), view.data()));
        }
        let raw: Vec<(&String, &Entry, Vec<u8>)> = entries.iter().map(|(n, e)| (n, e, e.to_bytes())).collect();
        let got = digest(raw.iter().map(|(n, e, b)| (n.as_str(), *e, b.as_slice())), &header.metadata);
        if got != header.sha256 {
            return Err(CheckpointError::Digest { path: path.to_path_buf(), expected: header.sha256, got });
        }
        let metadata: BTreeMap<String, serde_json::Value> =
            serde_json::from_str(&header.metadata).map_err(|e| fail(format!("metadata: {e}")))?;
        Ok(Self { entries, metadata, origin: path.display().to_string() })
    }
}

/// A cut-off file deserves a clearer message than the reader's.
fn check_length(bytes: &[u8], path: &Path) -> Result<(), CheckpointError> {
    let got = bytes.len() as u64;
    let wrong = |expected| Err(CheckpointError::Length { path: path.to_path_buf(), expected, got });
    let Some(first) = bytes.first_chunk::<8>() else { return wrong(8) };
    let header = u64::from_le_bytes(*first);
    if header > 100_000_000 {
        return Err(CheckpointError::Format { path: path.to_path_buf(), why: format!("header of {header} bytes") });
    }
    if got < 8 + header {
        return wrong(8 + header);
    }
    // Only to know the length: the safetensors reader checks everything else (and refuses what is no header at all).
    let json = bytes.get(8..8 + header as usize).unwrap_or_default();
    let Ok(tensors) = serde_json::from_slice::<BTreeMap<String, serde_json::Value>>(json) else { return Ok(()) };
    let end = |t: &serde_json::Value| t.get("data_offsets")?.get(1)?.as_u64();
    let expected = tensors.values().filter_map(end).max().unwrap_or(0).saturating_add(8 + header);
    if expected == got { Ok(()) } else { wrong(expected) }
}

/// SHA-256 over everything the file says: metadata, and each entry's name, type, shape and bytes in order of names.
fn digest<'a>(entries: impl Iterator<Item = (&'a str, &'a Entry, &'a [u8])>, metadata: &str) -> String {
    let mut hash = Sha256::new();
    let mut part = |bytes: &[u8]| {
        hash.update((bytes.len() as u64).to_le_bytes());
        hash.update(bytes);
    };
    part(metadata.as_bytes());
    for (name, entry, bytes) in entries {
        part(name.as_bytes());
        part(format!("{:?} {:?}", entry.kind(), entry.shape()).as_bytes());
        part(bytes);
    }
    hash.finalize().iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use proptest::prelude::*;

    use super::*;

    fn sample() -> Checkpoint {
        let mut checkpoint = Checkpoint::new();
        checkpoint.put_f32("weight", &[2, 3], vec![0.5; 6]).unwrap();
        checkpoint.put_u64("counts", &[2], vec![1, u64::MAX]).unwrap();
        checkpoint.set_meta("plan", &BTreeMap::from([("steps", 12)])).unwrap();
        checkpoint
    }

    /// Returns a file of the pieces of another one; the length of its header is right.
    fn with_header(good: &[u8], change: impl Fn(&str) -> String) -> Vec<u8> {
        let length = u64::from_le_bytes(*good.first_chunk().unwrap()) as usize;
        let header = change(std::str::from_utf8(&good[8..8 + length]).unwrap());
        [&(header.len() as u64).to_le_bytes(), header.as_bytes(), &good[8 + length..]].concat()
    }

    proptest! {
        #[test]
        fn files_are_whole_or_refused(
            spots in prop::collection::vec((any::<prop::sample::Index>(), 0..9usize, "[-0-9e,:\\\\\"\\[\\]{} a-zFU]{0,6}"), 1..4),
            cut in any::<prop::sample::Index>(),
            with: u8,
        ) {
            let good = sample().to_bytes().unwrap();
            let read = |bytes: &[u8]| Checkpoint::from_bytes(bytes, Path::new("x"));
            let header = with_header(&good, |header| {
                let mut text = header.to_owned();
                for (place, length, put) in &spots {
                    let from = place.index(text.len());
                    text.replace_range(from..(from + length).min(text.len()), put);
                }
                text
            });
            // White space and the like may change; what is read may not.
            if let Ok(checkpoint) = read(&header) {
                let whole = sample();
                prop_assert_eq!(checkpoint.entries(), whole.entries());
                prop_assert_eq!(checkpoint.metadata(), whole.metadata());
            }
            let mut bytes = good.clone();
            let at = cut.index(good.len());
            bytes[at] = with;
            prop_assert!(with == good[at] || read(&bytes).map_or(true, |c| c.entries() == sample().entries()), "byte {at}");
            prop_assert!(read(&good[..at]).is_err(), "cut at {at}");
        }

        #[test]
        fn random_bytes_are_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            prop_assert!(Checkpoint::from_bytes(&bytes, Path::new("x")).is_err());
        }
    }
}
