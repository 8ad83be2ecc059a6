//! The folder of a run.

use std::path::Path;

use lifelike_report::run::RunFolder;
use serde_json::json;

use super::next_steps;
use crate::error::CliError;
use crate::next;
use crate::output::{Output, shows_all_columns, table};

/// Prints how a run is.
pub fn inspect(path: &Path, output: &Output) -> Result<(), CliError> {
    let run = RunFolder::open(path)?;
    let plan: toml::Table = run.plan()?;
    let metrics = run.metrics()?;
    let checkpoints = run.checkpoints(0).list();
    let last = metrics.last();
    let steps = next_steps::of_run(path, &plan);
    // Not every iteration of a long run has a line.
    let iterations = checkpoints.last().map_or(0, |c| c.iteration).max(last.map_or(0, |row| row.iteration));
    let value = json!({
        "kind": "run", "plan": plan, "iterations": iterations,
        "last": last.map(|row| row.values.iter().cloned().collect::<std::collections::BTreeMap<String, f64>>()),
        "checkpoints": checkpoints.iter().map(|c| c.iteration).collect::<Vec<_>>(),
        "next": next::texts(&steps),
        "report": run.report_path().is_file().then(|| run.report_path()),
    });
    output.result(&value, || {
        let all = shows_all_columns();
        let mut text = format!("{}: a run of {} iterations so far\n\n", path.display(), iterations);
        if let Some(row) = last {
            let shown = row.values.iter().filter(|(name, _)| all || name.starts_with("Train/"));
            let rows: Vec<Vec<String>> = shown.map(|(n, v)| vec![n.clone(), format!("{v:.5}")]).collect();
            text += &table(&[&format!("iteration {}", row.iteration), "value"], &rows);
        }
        let kept: Vec<String> = checkpoints.iter().map(|c| c.iteration.to_string()).collect();
        text += &format!("\ncheckpoints at iterations: {}\n", kept.join(", "));
        if run.report_path().is_file() {
            text += &format!("report: {}\n", run.report_path().display());
        }
        text += &if all {
            format!("\n{}\n", toml::to_string_pretty(&plan).unwrap_or_default())
        } else {
            format!("plan: {}\nall metrics, and the plan: --wide\n", path.join("plan.toml").display())
        };
        text + &next::lines(&steps)
    })
}
