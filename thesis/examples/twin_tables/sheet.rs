//! Results of one table as a file that grows row by row.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::common::{Numbers, Outcome, Settings};

/// Numbers of one row, by test.
pub type Cells = BTreeMap<String, Numbers>;

/// One row.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Row {
    part: String,
    name: String,
    cells: Cells,
}

#[derive(Debug, Serialize, Deserialize)]
struct File {
    what: String,
    settings: Settings,
    rows: Vec<Row>,
}

/// The rows of one table. What is there already is not computed again.
pub struct Sheet {
    path: PathBuf,
    file: File,
}

impl Sheet {
    /// Opens FOLDER/WHAT.json, or begins it.
    pub fn open(folder: &str, what: &str, settings: Settings) -> Outcome<Self> {
        let path = Path::new(folder).join(format!("{what}.json"));
        std::fs::create_dir_all(folder)?;
        let file = match std::fs::read_to_string(&path) {
            Ok(text) => serde_json::from_str(&text)?,
            Err(_) => File { what: what.into(), settings, rows: Vec::new() },
        };
        if file.settings != settings {
            let expected = format!("{:?}", file.settings);
            return Err(
                format!("{}: expected {expected}, got {settings:?}; choose another folder", path.display()).into()
            );
        }
        Ok(Self { path, file })
    }

    /// Returns its file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns what it was made with.
    pub fn settings(&self) -> Settings {
        self.file.settings
    }

    /// Returns the cells of a row that is there.
    pub fn row(&self, part: &str, name: &str) -> Option<&Cells> {
        self.file.rows.iter().find(|row| row.part == part && row.name == name).map(|row| &row.cells)
    }

    /// Adds rows that `compute` returns under these names, unless all are there.
    pub fn rows(&mut self, part: &str, names: &[String], compute: impl FnOnce() -> Outcome<Vec<Cells>>) -> Outcome<()> {
        if names.iter().any(|name| self.row(part, name).is_none()) {
            for (name, cells) in names.iter().zip(compute()?) {
                self.file.rows.retain(|row| row.part != part || row.name != *name);
                self.file.rows.push(Row { part: part.into(), name: name.clone(), cells });
            }
            let text = serde_json::to_string_pretty(&self.file)?;
            let written = self.path.with_extension("json.new");
            std::fs::write(&written, text)?;
            std::fs::rename(written, &self.path)?;
        }
        for name in names {
            let cells = self.row(part, name).into_iter().flatten().map(|(test, n)| format!("  {test}: {n}"));
            println!("{part:<14} {name:<44}{}", cells.collect::<String>());
        }
        Ok(())
    }
}

/// Prints every sheet of a folder as a Markdown table: mean absolute and largest error, ± the deviation over seeds.
pub fn markdown(folder: &str) -> Outcome<()> {
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<Result<_, std::io::Error>>()?;
    files.retain(|file| file.extension().is_some_and(|own| own == "json"));
    files.sort();
    for file in files {
        let File { what, settings, rows } = serde_json::from_str(&std::fs::read_to_string(&file)?)?;
        let tests: BTreeSet<&String> = rows.iter().flat_map(|row| row.cells.keys()).collect();
        let Settings { iterations, seeds, runs } = settings;
        println!("**{what}** ({iterations} iterations, {seeds} seeds, {runs} runs)\n");
        println!("| | | {} |", tests.iter().map(|test| test.as_str()).collect::<Vec<_>>().join(" | "));
        println!("| --- | --- |{}", " ---: |".repeat(tests.len()));
        for Row { part, name, cells } in &rows {
            let cell = |test: &&String| {
                cells.get(*test).map_or(String::new(), |Numbers { mae, max, .. }| {
                    format!("{:.3} ± {:.3}, {:.2} ± {:.2}", mae[0], mae[1], max[0], max[1])
                })
            };
            println!("| {part} | {name} | {} |", tests.iter().map(cell).collect::<Vec<_>>().join(" | "));
        }
        println!();
    }
    Ok(())
}
