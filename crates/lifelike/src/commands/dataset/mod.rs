//! `lifelike dataset ...`: motion with captions.

pub mod captures;
pub mod check;
pub mod grammar;
pub mod humanml3d;

use std::collections::BTreeMap;
use std::path::Path;

use clap::Subcommand;
use lifelike_language::{CaptionedSet, Split};
use serde_json::{Value, json};

use crate::error::CliError;
use crate::output::{Output, table};

/// Make captioned motion of a robot, which text-to-motion learns from, and check what it promises.
///
/// A data set is a folder of clips with an index, dataset.jsonl: file, split, captions, facts.
#[derive(Debug, Subcommand)]
#[allow(missing_docs)] // a comment on a variant would take the place of the command's help text
pub enum Dataset {
    Grammar(grammar::Args),
    Captures(captures::Args),
    Humanml3d(humanml3d::Args),
    Check(check::Args),
}

impl Dataset {
    /// Runs it.
    ///
    /// # Errors
    /// As the command.
    pub fn run(self, output: &Output) -> Result<(), CliError> {
        match self {
            Self::Grammar(args) => grammar::run(&args, output),
            Self::Captures(args) => captures::run(&args, output),
            Self::Humanml3d(args) => humanml3d::run(&args, output),
            Self::Check(args) => check::run(&args, output),
        }
    }
}

/// Returns whether a folder holds no files. A run that was killed at once leaves empty folders and files whose names begin with a
/// dot.
fn is_unused(folder: &Path) -> bool {
    let is_hidden = |path: &Path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
    let mut entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    entries.all(|path| if path.is_dir() { is_unused(&path) } else { is_hidden(&path) })
}

/// Makes the folders of all splits in a folder that is new or empty: clips of another data set would stay in it.
fn make_folders(folder: &Path) -> Result<(), CliError> {
    if !is_unused(folder) {
        let message = format!("{}: expected a new or empty folder, got files in it", folder.display());
        return Err(CliError::Input(message));
    }
    Split::ALL.iter().try_for_each(|split| {
        let path = folder.join(split.name());
        std::fs::create_dir_all(&path).map_err(CliError::write(&path))
    })
}

/// Returns the rejected motions by reason: a table, largest first.
fn rejected_table(rejected: &BTreeMap<String, usize>, drawn: usize) -> String {
    let mut sorted: Vec<(&String, &usize)> = rejected.iter().filter(|(_, count)| **count > 0).collect();
    sorted.sort_by_key(|(reason, count)| (std::cmp::Reverse(**count), *reason));
    let row = |(reason, count): (&String, &usize)| {
        vec![reason.clone(), count.to_string(), format!("{:.1}", 100.0 * *count as f64 / drawn.max(1) as f64)]
    };
    table(&["left out", "count", "% of all"], &sorted.into_iter().map(row).collect::<Vec<_>>())
}

/// Extent of a set, split by split, for scripts.
fn extent(set: &CaptionedSet) -> Value {
    let of = |split: Split| {
        let captions: usize = set.of(split).map(|entry| entry.captions.len()).sum();
        let hours = set.seconds(split) / 3600.0;
        (split.name().to_string(), json!({ "clips": set.of(split).count(), "captions": captions, "hours": hours }))
    };
    Value::Object(Split::ALL.into_iter().map(of).collect())
}

/// Extent of a set as a table.
fn extent_table(set: &CaptionedSet) -> String {
    let rows = Split::ALL.map(|split| {
        let captions: usize = set.of(split).map(|entry| entry.captions.len()).sum();
        let hours = format!("{:.2}", set.seconds(split) / 3600.0);
        vec![split.name().to_string(), set.of(split).count().to_string(), captions.to_string(), hours]
    });
    table(&["split", "clips", "captions", "hours"], &rows)
}
