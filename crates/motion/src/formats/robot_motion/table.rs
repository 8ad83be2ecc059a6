//! Tables of numbers as text: rows of commas, with or without names of the columns.

use std::borrow::Cow;
use std::path::Path;

use crate::error::MotionError;
use crate::formats::text::{decode, parse_error};

/// No length (mm), angle (deg) or time is larger; anything beyond is a broken file.
const LARGEST: f64 = 1e6;

/// A table.
pub(super) struct Table {
    /// Names of the columns, where the first row has them.
    pub(super) header: Option<Vec<String>>,
    /// Numbers, row after row.
    numbers: Vec<f64>,
    columns: usize,
}

impl Table {
    /// Returns whether a text begins with a row of numbers, or with names of a layout's columns.
    pub(super) fn is_start(start: &[u8], names: impl Fn(&str) -> bool) -> bool {
        let line = start.split(|byte| *byte == b'\n').next().unwrap_or_default();
        let Ok(line) = std::str::from_utf8(line) else { return false };
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        cells.len() >= 8
            && (cells.iter().all(|cell| cell.parse::<f64>().is_ok()) || cells.iter().any(|cell| names(cell)))
    }

    /// Reads a table: cells between commas, semicolons, tabs or spaces, comments after `#`.
    ///
    /// # Errors
    /// [`MotionError::Parse`] with the line.
    pub(super) fn parse(bytes: &[u8], file: &Path) -> Result<Self, MotionError> {
        let text = with_commas(decode(bytes, file)?);
        let mut reader = csv::ReaderBuilder::new();
        reader.has_headers(false).trim(csv::Trim::All).comment(Some(b'#'));
        let mut reader = reader.from_reader(text.as_bytes());
        let mut table = Self { header: None, numbers: Vec::new(), columns: 0 };
        for (row, record) in reader.records().enumerate() {
            let record = record.map_err(|error| {
                let line = error.position().map_or(1, |position| position.line() as usize);
                parse_error(file, line, format!("{} columns in every row", table.columns), &error.to_string())
            })?;
            let line = record.position().map_or(row + 1, |position| position.line() as usize);
            if row == 0 {
                table.columns = record.len();
                // A table without names that pandas wrote has its columns' numbers for names.
                if record.len() > 1 && record.iter().enumerate().all(|(column, cell)| cell == column.to_string()) {
                    continue;
                }
                if record.iter().any(|cell| cell.parse::<f64>().is_err()) {
                    table.header = Some(record.iter().map(str::to_owned).collect());
                    continue;
                }
            }
            for cell in &record {
                let number = cell.parse::<f64>().ok().filter(|number| number.abs() < LARGEST);
                table.numbers.push(number.ok_or_else(|| parse_error(file, line, "a number", cell))?);
            }
        }
        match table.numbers.is_empty() {
            true => Err(parse_error(file, 1, "rows of numbers", "no row")),
            false => Ok(table),
        }
    }

    pub(super) fn columns(&self) -> usize {
        self.columns
    }

    /// Returns the rows.
    pub(super) fn rows(&self) -> std::slice::ChunksExact<'_, f64> {
        self.numbers.chunks_exact(self.columns.max(1))
    }

    /// Returns the place of a column.
    pub(super) fn column(&self, name: &str) -> Option<usize> {
        self.header.as_ref()?.iter().position(|column| column == name)
    }
}

/// Returns a table with commas between its cells, in place of semicolons, tabs or spaces. Lines keep their numbers.
fn with_commas(text: &str) -> Cow<'_, str> {
    let first = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#')).unwrap_or_default();
    if first.contains(';') {
        // A comma beside semicolons is a decimal one.
        return text.replace(',', ".").replace(';', ",").into();
    }
    if first.contains(',') || first.split_whitespace().count() < 2 {
        return text.into();
    }
    text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(",") + "\n").collect::<String>().into()
}

/// Writes rows under names, or none. Numbers read back to the same value.
pub(super) fn write(header: Option<&[String]>, rows: impl Iterator<Item = Vec<f64>>) -> Result<Vec<u8>, String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let words = |error: csv::Error| error.to_string();
    if let Some(header) = header {
        writer.write_record(header).map_err(words)?;
    }
    for row in rows {
        writer.write_record(row.iter().map(f64::to_string)).map_err(words)?;
    }
    writer.into_inner().map_err(|error| error.to_string())
}
