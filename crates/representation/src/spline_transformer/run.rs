//! The loss of validation against iterations and time, from the files of a run.

use std::fs;
use std::path::Path;

use lifelike_report::run::{RunFolder, read_metrics};
use serde::Serialize;

use crate::RepresentationError;

/// Errors of the validation set at one moment of a training.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ValidationPoint {
    /// Iterations done.
    pub iteration: u64,
    /// Time spent training until then, all sittings together (s). NaN where the clock's file does not know.
    pub seconds: f64,
    /// Mean squared error.
    pub mse: f64,
    /// As [`super::SequenceErrors::spread`].
    pub spread: f64,
}

/// Reads the validations of a run so far.
///
/// # Errors
/// Not a run's folder, or files that are not what they should be.
pub fn validation_points(folder: &Path) -> Result<Vec<ValidationPoint>, RepresentationError> {
    let run = RunFolder::open(folder)?;
    let times = seconds(&run)?;
    let of = |values: &[(String, f64)], name: &str| values.iter().find(|(n, _)| n == name).map(|(_, v)| *v);
    let mut points = Vec::new();
    for row in run.metrics()? {
        let Some(mse) = of(&row.values, "Validation/mse") else { continue };
        // A stopped run may have passed an iteration twice; the later time is the one that counts.
        let seconds = times.iter().rfind(|(i, _)| *i == row.iteration).map_or(f64::NAN, |(_, s)| *s);
        let spread = of(&row.values, "Validation/spread").unwrap_or(f64::NAN);
        points.push(ValidationPoint { iteration: row.iteration, seconds, mse, spread });
    }
    Ok(points)
}

/// Iterations and the time spent until then (s).
fn seconds(run: &RunFolder) -> Result<Vec<(u64, f64)>, RepresentationError> {
    if !fs::exists(run.timing_path()).unwrap_or(false) {
        return Ok(Vec::new());
    }
    let rows = read_metrics(&run.timing_path())?.into_iter();
    let wall_time = |values: Vec<(String, f64)>| values.into_iter().find(|(name, _)| name == "Perf/wall_time");
    Ok(rows.filter_map(|row| Some((row.iteration, wall_time(row.values)?.1))).collect())
}
