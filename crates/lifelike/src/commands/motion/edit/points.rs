//! Control points as a JSON file that people and other programs can change.

use std::path::Path;

use lifelike_representation::motion_spline::{Segment, SplinedClip};
use serde::{Deserialize, Serialize};

use crate::error::CliError;

/// `segments[k].control_points[i]` are the numbers of point i of segment k, which begins at `start` seconds.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Points {
    clip: String,
    segments: Vec<Segment>,
}

/// Writes the control points as they are.
pub fn write(file: &Path, clip: &SplinedClip) -> Result<(), CliError> {
    let points = Points { clip: clip.clip().name.clone(), segments: clip.segments().to_vec() };
    crate::output::write_json(file, &points)
}

/// Puts a file's control points into the clip; they need not be of this clip, but as many.
pub fn read(file: &Path, clip: &mut SplinedClip) -> Result<(), CliError> {
    let input = |e: &dyn std::fmt::Display| CliError::Input(format!("{}: {e}", file.display()));
    let text = std::fs::read_to_string(file).map_err(|e| input(&e))?;
    let points: Points = serde_json::from_str(&text).map_err(|e| input(&e))?;
    clip.set_segments(points.segments).map_err(|e| input(&e))
}
