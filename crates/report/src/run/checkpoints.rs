//! The checkpoints of a run: atomic, verified by digest, the last few and the best kept.

use std::fs;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::atomic::{PARTIAL, write_atomically};
use crate::{FromInput, ReportError};

/// The small text beside each checkpoint. It is written after the checkpoint: a checkpoint without it never happened.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CheckpointInfo {
    /// Iterations done when it was made.
    pub iteration: u64,
    /// Score, higher is better; `None` where nothing was measured.
    pub score: Option<f64>,
    /// Size (bytes).
    pub bytes: u64,
    /// SHA-256 of the content, hexadecimal.
    pub sha256: String,
}

/// The folder `checkpoints/` of a run.
#[derive(Debug, Clone)]
pub struct Checkpoints {
    folder: PathBuf,
    keep: usize,
}

impl Checkpoints {
    /// Returns the checkpoints in a folder (made when the first is saved), of which the last `keep` (at least one) and the best
    /// are kept.
    pub fn new(folder: impl Into<PathBuf>, keep: usize) -> Self {
        Self { folder: folder.into(), keep: keep.max(1) }
    }

    /// Returns the file of one checkpoint.
    pub fn path(&self, iteration: u64) -> PathBuf {
        self.folder.join(format!("{iteration:08}.safetensors"))
    }

    fn info_path(&self, iteration: u64) -> PathBuf {
        self.folder.join(format!("{iteration:08}.json"))
    }

    /// Saves a checkpoint and forgets those no longer worth keeping. Killed at any moment, the folder holds either the
    /// new one whole or the old ones as they were.
    ///
    /// # Errors
    /// [`ReportError::Input`].
    pub fn save(&self, iteration: u64, score: Option<f64>, bytes: &[u8]) -> Result<PathBuf, ReportError> {
        fs::create_dir_all(&self.folder).map_err(ReportError::io(&self.folder))?;
        let path = self.path(iteration);
        let info_path = self.info_path(iteration);
        let info = CheckpointInfo {
            iteration,
            score: score.filter(|s| s.is_finite()),
            bytes: bytes.len() as u64,
            sha256: digest(bytes),
        };
        let text = serde_json::to_string(&info)
            .map_err(|e| ReportError::format(info_path.display(), "a description that can be written as JSON", e))?;
        write_atomically(&path, bytes)?;
        write_atomically(&info_path, text.as_bytes())?;
        self.prune()?;
        tracing::debug!("checkpoint of iteration {iteration}: {}", path.display());
        Ok(path)
    }

    /// Returns the checkpoints there are, oldest first. Files without a readable description are no checkpoints.
    pub fn list(&self) -> Vec<CheckpointInfo> {
        let Ok(entries) = fs::read_dir(&self.folder) else { return Vec::new() };
        let mut all: Vec<CheckpointInfo> = entries
            .flatten()
            .map(|e| e.path())
            .filter(|p| p.extension().is_some_and(|e| e == "json"))
            .filter_map(|p| serde_json::from_slice(&fs::read(p).ok()?).ok())
            .collect();
        all.sort_by_key(|info| info.iteration);
        all
    }

    /// Reads one checkpoint and checks it against its digest.
    ///
    /// # Errors
    /// [`ReportError::Input`], also when the content is not what was written.
    pub fn read(&self, info: &CheckpointInfo) -> Result<Vec<u8>, ReportError> {
        let path = self.path(info.iteration);
        let bytes = fs::read(&path).map_err(ReportError::io(&path))?;
        let got = digest(&bytes);
        if got == info.sha256 {
            return Ok(bytes);
        }
        let expected = format!("{} bytes with SHA-256 {}", info.bytes, info.sha256);
        Err(ReportError::format(path.display(), expected, format!("{} bytes with SHA-256 {got}", bytes.len())))
    }

    /// Returns the newest checkpoint that is whole. Damaged ones are passed over with a warning.
    pub fn latest(&self) -> Option<(CheckpointInfo, Vec<u8>)> {
        self.list().into_iter().rev().find_map(|info| match self.read(&info) {
            Ok(bytes) => Some((info, bytes)),
            Err(error) => {
                tracing::warn!("passing over a damaged checkpoint: {error}");
                None
            }
        })
    }

    /// Returns the checkpoint with the highest score (the earliest of equals), or the newest where none was measured.
    pub fn best(&self) -> Option<CheckpointInfo> {
        best_of(&self.list()).or_else(|| self.list().pop())
    }

    fn prune(&self) -> Result<(), ReportError> {
        let all = self.list();
        let best = best_of(&all).map(|info| info.iteration);
        let first_kept = all.len().saturating_sub(self.keep);
        for info in &all[..first_kept] {
            if Some(info.iteration) != best {
                // The description first: without it the rest is not a checkpoint any more.
                remove(&self.info_path(info.iteration))?;
            }
        }
        // Contents without a description, and halves of files: left by a kill.
        let described: Vec<PathBuf> = self.list().iter().map(|info| self.path(info.iteration)).collect();
        let entries = fs::read_dir(&self.folder).map_err(ReportError::io(&self.folder))?;
        for path in entries.flatten().map(|e| e.path()) {
            let ending = path.extension().unwrap_or_default();
            if ending == PARTIAL || (ending == "safetensors" && !described.contains(&path)) {
                remove(&path)?;
            }
        }
        Ok(())
    }
}

fn best_of(all: &[CheckpointInfo]) -> Option<CheckpointInfo> {
    let mut best: Option<(f64, &CheckpointInfo)> = None;
    for info in all {
        if let Some(score) = info.score
            && best.is_none_or(|(top, _)| score > top)
        {
            best = Some((score, info));
        }
    }
    best.map(|(_, info)| info.clone())
}

fn remove(path: &Path) -> Result<(), ReportError> {
    fs::remove_file(path).map_err(ReportError::io(path))
}

fn digest(bytes: &[u8]) -> String {
    use std::fmt::Write;
    Sha256::digest(bytes).iter().fold(String::with_capacity(64), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn iterations(c: &Checkpoints) -> Vec<u64> {
        c.list().iter().map(|i| i.iteration).collect()
    }

    #[test]
    fn the_last_few_and_the_best_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let c = Checkpoints::new(folder.path().join("checkpoints"), 2);
        for (iteration, score) in [(1, 0.1), (2, 0.9), (3, 0.2), (4, f64::NAN), (5, 0.3)] {
            c.save(iteration, Some(score), &[iteration as u8]).unwrap();
        }
        assert_eq!(iterations(&c), [2, 4, 5]);
        assert_eq!(c.best().unwrap().iteration, 2);
        assert_eq!(c.latest().unwrap().1, [5]);
        assert_eq!(fs::read_dir(folder.path().join("checkpoints")).unwrap().count(), 6, "three files and three texts");
    }

    #[test]
    fn a_damaged_checkpoint_is_passed_over() {
        let folder = tempfile::tempdir().unwrap();
        let c = Checkpoints::new(folder.path(), 3);
        c.save(1, None, b"good").unwrap();
        c.save(2, None, b"also good").unwrap();
        fs::write(c.path(2), b"also g").unwrap();
        let (info, bytes) = c.latest().unwrap();
        assert_eq!((info.iteration, bytes.as_slice()), (1, b"good".as_slice()));
        assert!(c.read(&c.list()[1]).unwrap_err().to_string().contains("00000002"));
    }

    #[test]
    fn what_a_kill_left_behind_is_no_checkpoint_and_goes_away() {
        let folder = tempfile::tempdir().unwrap();
        let c = Checkpoints::new(folder.path(), 3);
        c.save(1, None, b"one").unwrap();
        fs::write(c.path(2), b"written, but its description was not").unwrap();
        fs::write(folder.path().join("00000003.safetensors.partial"), b"half").unwrap();
        assert_eq!(c.latest().unwrap().0.iteration, 1);
        c.save(4, None, b"four").unwrap();
        assert_eq!(iterations(&c), [1, 4]);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4);
    }

    #[test]
    fn the_digest_is_sha256() {
        // FIPS 180-2, appendix B.1.
        assert_eq!(digest(b"abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }
}
