//! Record of what a co-training has done, in its folder.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::measure::Pair;
use crate::error::CliError;

/// In a run's folder.
const FILE: &str = "cotrain.json";

/// Stages that are complete, and what was measured.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Done {
    /// Complete stages, as `round-1/tracker`.
    stages: BTreeSet<String>,
    /// Every generator with every tracker.
    pub measured: Vec<Pair>,
    #[serde(skip)]
    file: PathBuf,
}

impl Done {
    /// Reads the record of a run; empty where it has just begun.
    pub fn read(folder: &Path) -> Result<Self, CliError> {
        let file = folder.join(FILE);
        let own = match std::fs::read_to_string(&file) {
            Ok(text) => serde_json::from_str(&text).map_err(|e| CliError::Input(format!("{}: {e}", file.display())))?,
            Err(_) => Self::default(),
        };
        Ok(Self { file, ..own })
    }

    /// Returns whether a stage is complete.
    pub fn has(&self, stage: &str) -> bool {
        self.stages.contains(stage)
    }

    /// Notes that a stage is complete.
    pub fn add(&mut self, stage: String) -> Result<(), CliError> {
        self.stages.insert(stage);
        crate::output::write_json(&self.file, self)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_record_comes_back_and_a_broken_one_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let mut done = Done::read(folder.path()).unwrap();
        done.measured.push(Pair { generator: 1, tracker: 0, survival: 0.5, ..Pair::default() });
        done.add("round-1/tracker".into()).unwrap();
        let back = Done::read(folder.path()).unwrap();
        assert!(back.has("round-1/tracker") && !back.has("round-1/critic"));
        assert_eq!(back.measured, done.measured);
        std::fs::write(folder.path().join(FILE), "{").unwrap();
        assert!(Done::read(folder.path()).unwrap_err().to_string().contains(FILE));
    }
}
