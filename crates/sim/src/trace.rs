//! Recorded motion of building blocks: what simulation augmentation (thesis chapter 2) sees of a robot.
//!
//! A [`Trace`] is one run, at equal time steps. A [`BlockTrace`] is one actuator or one rigid body in it, by name, and of a class
//! whose members are alike: simulated state s(t), constraint forces f_C(t), references r(t) and measured state s̄(t), each as
//! [`Columns`] with names. The selection S of eq. 2.2 says what a measured number is of the state.
//!
//! [`record`] writes one of a simulation; [`container`] keeps it in a file.

pub mod container;
mod record;

pub use record::{ACTUATOR, BODY, BODY_FORCE, FRAME, Recorder};

use crate::error::SimError;

/// Named columns of numbers, row by row.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Columns {
    /// Names, such as `position`.
    pub names: Vec<String>,
    /// Numbers in SI units, `[rows, names]`.
    pub values: Vec<f32>,
}

impl Columns {
    /// Returns columns of these names, from one list for each.
    ///
    /// # Panics
    /// Lists of different lengths.
    pub fn new(columns: &[(&str, &[f64])]) -> Self {
        let rows = columns.first().map_or(0, |(_, values)| values.len());
        assert!(columns.iter().all(|(_, values)| values.len() == rows), "columns of one length");
        let values = (0..rows).flat_map(|row| columns.iter().map(move |(_, values)| values[row] as f32)).collect();
        Self { names: columns.iter().map(|(name, _)| (*name).into()).collect(), values }
    }

    /// Returns the number of a name.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|own| own == name)
    }

    /// Returns one column's numbers; none where there is no such name.
    pub fn column(&self, name: &str) -> Option<impl ExactSizeIterator<Item = f32> + '_> {
        let (index, width) = (self.index(name)?, self.names.len());
        Some(self.values.chunks_exact(width).map(move |row| row[index]))
    }

    /// Returns the rows.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[f32]> {
        self.values.chunks_exact(self.names.len().max(1))
    }
}

/// A column of the state that a measured column is to be compared with (a row of S).
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Selected {
    /// Name of the measured column.
    pub measured: String,
    /// The state's columns and their factors: the measured number is the sum of factor times column.
    pub state: Vec<(String, f32)>,
}

/// One building block of a run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BlockTrace {
    /// Name, such as the joint's.
    pub name: String,
    /// Class: blocks of one class are alike and have the same columns (`xl330`, `rigid_body`).
    pub class: String,
    /// s(t).
    pub simulated: Columns,
    /// f_C(t).
    pub force: Columns,
    /// r(t).
    pub reference: Columns,
    /// s̄(t); without columns where nothing was measured.
    pub measured: Columns,
    /// S, a row for each measured column.
    pub selection: Vec<Selected>,
    /// Simulated pose of a body's parent ([`FRAME`]), in which its numbers may be expressed; without columns for other blocks.
    pub frame: Columns,
}

impl BlockTrace {
    /// Returns S s(t), the simulated numbers that the measured ones are compared with, `[rows, measured]`.
    pub fn selected(&self) -> Vec<f32> {
        let width = self.simulated.names.len().max(1);
        let terms: Vec<Vec<(usize, f32)>> = self
            .selection
            .iter()
            .map(|row| {
                row.state.iter().filter_map(|(name, factor)| Some((self.simulated.index(name)?, *factor))).collect()
            })
            .collect();
        let rows = self.simulated.values.chunks_exact(width);
        rows.flat_map(|row| terms.iter().map(move |terms| terms.iter().map(|(i, f)| row[*i] * f).sum())).collect()
    }

    /// Returns Δs̄(t) = s̄(t) - S s(t) (eq. 2.2), `[rows, measured]`; empty where nothing was measured.
    pub fn error(&self) -> Vec<f32> {
        self.measured.values.iter().zip(self.selected()).map(|(measured, simulated)| measured - simulated).collect()
    }

    /// Returns S that compares every measured column with the state's column of the same name.
    pub fn by_name(&self) -> Vec<Selected> {
        let row = |name: &String| Selected { measured: name.clone(), state: vec![(name.clone(), 1.0)] };
        self.measured.names.iter().map(row).collect()
    }
}

/// One run of a robot, simulated, measured or both.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trace {
    /// Name of the run.
    pub name: String,
    /// Origin of the trace: engine and robot, or the log.
    pub source: String,
    /// Rows per second (Hz).
    pub rate: f64,
    /// Its building blocks.
    pub blocks: Vec<BlockTrace>,
}

impl Trace {
    /// Returns the number of rows.
    pub fn len(&self) -> usize {
        self.blocks.first().map_or(0, |block| {
            let parts = [&block.simulated, &block.measured, &block.reference];
            parts.into_iter().find(|columns| !columns.names.is_empty()).map_or(0, |columns| columns.rows().len())
        })
    }

    /// Returns true when there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Checks that rows, names and S fit together and that all numbers are finite.
    ///
    /// # Errors
    /// [`SimError::State`] with block, column and row.
    pub fn check(&self) -> Result<(), SimError> {
        let wrong = |expected: String, got: String| Err(SimError::State { expected, got });
        if !(self.rate.is_finite() && self.rate > 0.0) {
            return wrong(format!("trace '{}' with a rate above 0 Hz", self.name), self.rate.to_string());
        }
        let rows = self.len();
        for block in &self.blocks {
            let parts = [
                ("simulated", &block.simulated),
                ("force", &block.force),
                ("reference", &block.reference),
                ("measured", &block.measured),
                ("frame", &block.frame),
            ];
            for (part, columns) in parts {
                let width = columns.names.len();
                let at = format!("trace '{}', block '{}', {part}", self.name, block.name);
                if columns.values.len() != rows * width {
                    let expected = format!("{at}: {rows} rows of {width} numbers");
                    return wrong(expected, format!("{} numbers", columns.values.len()));
                }
                if let Some(i) = columns.values.iter().position(|x| !x.is_finite()) {
                    let expected = format!("{at}: a finite '{}' in row {}", columns.names[i % width], i / width);
                    return wrong(expected, columns.values[i].to_string());
                }
            }
            let names: Vec<&String> = block.selection.iter().map(|row| &row.measured).collect();
            if names != block.measured.names.iter().collect::<Vec<_>>() {
                let expected = format!("block '{}': S with rows {:?}", block.name, block.measured.names);
                return wrong(expected, format!("{names:?}"));
            }
            let used = block.selection.iter().flat_map(|row| &row.state);
            for (name, _) in used.filter(|_| !block.simulated.names.is_empty()) {
                if block.simulated.index(name).is_none() {
                    let expected = format!("block '{}': S of columns {:?}", block.name, block.simulated.names);
                    return wrong(expected, format!("'{name}'"));
                }
            }
        }
        Ok(())
    }
}
