//! Reconstruction errors of a prior, as people and scripts read them.

use lifelike_representation::prior::{ReconstructionErrors, ReconstructionReport};
use serde_json::{Value, json};

/// Heads of the columns of [`row`].
pub const HEAD: [&str; 5] = ["mean error", "joints (deg)", "effectors (mm)", "height (mm)", "root (deg)"];

/// A row of a table.
pub fn row(name: &str, e: &ReconstructionErrors) -> Vec<String> {
    let numbers = [e.joints_deg, e.effectors_mm, e.height_mm, e.orientation_deg];
    std::iter::once(name.to_string()).chain(numbers.iter().map(|n| format!("{n:.2}"))).collect()
}

/// Everything, clip by clip.
pub fn value(report: &ReconstructionReport) -> Value {
    let clips: Vec<Value> = report.clips.iter().map(|(name, e)| json!({ "clip": name, "errors": e })).collect();
    json!({ "windows": report.windows, "window": report.window, "centre": report.centre, "clips": clips })
}
