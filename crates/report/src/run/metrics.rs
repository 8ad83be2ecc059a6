//! Metrics of a run, line by line.

use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use super::events::EventWriter;
use crate::{FromInput, ReportError};

/// Appends to `metrics.jsonl`, `timing.jsonl` and the TensorBoard events of a run.
#[derive(Debug)]
pub struct MetricsWriter {
    metrics: Lines,
    timing: Lines,
    events: EventWriter,
}

/// A text file that only grows, one whole line per write.
#[derive(Debug)]
struct Lines {
    path: PathBuf,
    file: File,
    bytes: u64,
}

impl Lines {
    fn append(path: &Path) -> Result<Self, ReportError> {
        let file = OpenOptions::new().create(true).append(true).open(path).map_err(ReportError::io(path))?;
        let bytes = file.metadata().map_err(ReportError::io(path))?.len();
        Ok(Self { path: path.to_path_buf(), file, bytes })
    }

    fn write(&mut self, line: &str) -> Result<(), ReportError> {
        self.file.write_all(line.as_bytes()).map_err(ReportError::io(&self.path))?;
        self.bytes += line.len() as u64;
        Ok(())
    }
}

impl MetricsWriter {
    /// Continues the files at `metrics_path` and `timing_path`; TensorBoard events go to a new file in `folder`.
    pub(super) fn append(
        metrics_path: &Path,
        timing_path: &Path,
        folder: &Path,
        first_step: u64,
    ) -> Result<Self, ReportError> {
        Ok(Self {
            metrics: Lines::append(metrics_path)?,
            timing: Lines::append(timing_path)?,
            events: EventWriter::create(folder, first_step)?,
        })
    }

    /// Logs what one iteration gave: only numbers that an equal run would give again. A name may have a group before a
    /// slash (`reward/joints`). Values that are not finite become `null`.
    ///
    /// # Errors
    /// [`ReportError::Input`].
    pub fn log(&mut self, iteration: u64, values: &[(&str, f64)]) -> Result<(), ReportError> {
        self.metrics.write(&line(iteration, values))?;
        self.events.scalars(iteration, values)
    }

    /// Logs what the clock says about one iteration (seconds, rates).
    ///
    /// # Errors
    /// [`ReportError::Input`].
    pub fn log_timing(&mut self, iteration: u64, values: &[(&str, f64)]) -> Result<(), ReportError> {
        self.timing.write(&line(iteration, values))?;
        self.events.scalars(iteration, values)
    }

    /// Makes sure that `metrics.jsonl` is on the disk, and returns its length (bytes): what a checkpoint remembers.
    ///
    /// # Errors
    /// [`ReportError::Input`].
    pub fn sync(&mut self) -> Result<u64, ReportError> {
        self.metrics.file.sync_all().map_err(ReportError::io(&self.metrics.path))?;
        Ok(self.metrics.bytes)
    }
}

/// Returns one line. Written by hand, so that the columns keep the caller's order.
fn line(iteration: u64, values: &[(&str, f64)]) -> String {
    let mut text = format!("{{\"iteration\":{iteration}");
    for (name, value) in values {
        text.push_str(&format!(",{}:{}", serde_json::Value::from(*name), serde_json::Value::from(*value)));
    }
    text.push_str("}\n");
    text
}

/// One line read back.
#[derive(Debug, Clone, PartialEq)]
pub struct MetricsRow {
    /// The iteration.
    pub iteration: u64,
    /// Names and values; what was not finite is NaN.
    pub values: Vec<(String, f64)>,
}

/// Reads `metrics.jsonl` or `timing.jsonl`. A last line without its end (a kill in the middle of a write) is left out.
///
/// # Errors
/// [`ReportError::Input`] with file and line.
pub fn read_metrics(path: &Path) -> Result<Vec<MetricsRow>, ReportError> {
    let text = fs::read_to_string(path).map_err(ReportError::io(path))?;
    let whole = text.rfind('\n').map_or("", |end| &text[..end]);
    whole
        .lines()
        .enumerate()
        .map(|(i, line)| {
            parse(line).map_err(|got| {
                ReportError::format(
                    format!("{}:{}", path.display(), i + 1),
                    "a JSON object with \"iteration\" and numbers",
                    got,
                )
            })
        })
        .collect()
}

fn parse(line: &str) -> Result<MetricsRow, String> {
    let object: serde_json::Map<String, serde_json::Value> = serde_json::from_str(line).map_err(|e| e.to_string())?;
    let iteration = object.get("iteration").and_then(serde_json::Value::as_u64).ok_or("no \"iteration\"")?;
    let mut values = Vec::with_capacity(object.len());
    for (name, value) in object.into_iter().filter(|(name, _)| name != "iteration") {
        let number = if value.is_null() { Some(f64::NAN) } else { value.as_f64() };
        values.push((name.clone(), number.ok_or_else(|| format!("\"{name}\": {value}"))?));
    }
    Ok(MetricsRow { iteration, values })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_line_keeps_the_order_and_every_bit_of_the_numbers() {
        let values = [("z", 0.1 + 0.2), ("a \"b\"", f64::NAN), ("m", -1e-300)];
        let text = line(3, &values);
        assert_eq!(text, "{\"iteration\":3,\"z\":0.30000000000000004,\"a \\\"b\\\"\":null,\"m\":-1e-300}\n");
        let row = parse(text.trim_end()).unwrap();
        assert_eq!(row.iteration, 3);
        let back = |name: &str| row.values.iter().find(|(n, _)| n == name).unwrap().1;
        assert_eq!(back("z").to_bits(), (0.1_f64 + 0.2).to_bits());
        assert!(back("a \"b\"").is_nan());
    }

    #[test]
    fn a_torn_last_line_is_left_out_and_a_bad_line_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("metrics.jsonl");
        fs::write(&path, "{\"iteration\":1,\"a\":2}\n{\"iteration\":2,\"a\":").unwrap();
        assert_eq!(read_metrics(&path).unwrap().len(), 1);
        fs::write(&path, "{\"iteration\":1,\"a\":2}\n{\"iteration\":2,\"a\":\"x\"}\n").unwrap();
        let error = read_metrics(&path).unwrap_err().to_string();
        assert!(error.contains("metrics.jsonl:2") && error.contains("\"x\""), "{error}");
    }
}
