//! The folder of a measurement: numbers and a page with the scatter plot.

use std::path::Path;

use lifelike_report::{Drawing, Panel, ReportBuilder, Table};

use super::Measured;
use super::episodes::Window;
use lifelike::CliError;

/// Most points of the plot.
const POINTS: usize = 3000;
/// Half the width of a point, in the values' units.
const HALF: f32 = 0.03;

/// Writes critic.json and report.html.
pub fn save(
    folder: &Path,
    result: &Measured,
    table: &Table,
    windows: &[Window],
    predicted: &[f64],
) -> Result<(), CliError> {
    std::fs::create_dir_all(folder).map_err(CliError::write(folder))?;
    lifelike::output::write_json(&folder.join("critic.json"), result)?;
    let report = ReportBuilder::new("A critic on motion that it did not learn from").table(table.clone());
    Ok(report.drawing(scatter(windows, predicted)).write(&folder.join("report.html"))?)
}

/// Measured returns over predicted values; on the thin diagonal they are equal.
fn scatter(windows: &[Window], predicted: &[f64]) -> Drawing {
    let stride = windows.len().div_ceil(POINTS).max(1);
    let points = || windows.iter().zip(predicted).step_by(stride).map(|(w, p)| [*p as f32, w.value as f32]);
    let [low, high] =
        points().flatten().fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
    let cross = |[x, y]: [f32; 2]| [vec![[x - HALF, y], [x + HALF, y]], vec![[x, y - HALF], [x, y + HALF]]];
    Drawing {
        title: "Predicted and measured".into(),
        caption: "To the right the critic's value, upwards the mean measured return of the window; equal on the line."
            .into(),
        panels: vec![Panel {
            name: "windows".into(),
            note: format!("{low:.1} to {high:.1}"),
            reference: vec![vec![[low, low], [high, high]]],
            lines: points().flat_map(cross).collect(),
            picture: None,
        }],
        across: 1,
    }
}
