//! `lifelike train tracker --keys`: every key of a plan with its default, unit and meaning.

use lifelike_tracking::plan::keys::{PlanKey, keys};
use serde::Serialize;

use crate::error::CliError;
use crate::output::{Output, table};

/// A key of a plan.
#[derive(Debug, Serialize)]
struct Row<'a> {
    key: &'a str,
    default: &'a str,
    unit: &'a str,
    about: &'a str,
}

/// Prints the keys of a tracker's plan.
pub fn tracker(output: &Output) -> Result<(), CliError> {
    let keys = keys().map_err(|e| CliError::Failed(format!("plan: {e}")))?;
    let row = |k: &PlanKey| [&k.key, &k.default, &k.unit, &k.meaning].map(Clone::clone).to_vec();
    let rows: Vec<Row<'_>> =
        keys.iter().map(|k| Row { key: &k.key, default: &k.default, unit: &k.unit, about: &k.meaning }).collect();
    output.result(&rows, || {
        let lines: Vec<Vec<String>> = keys.iter().map(row).collect();
        table(&["key", "default", "unit", "meaning"], &lines)
            + "\nGiven as KEY=VALUE on the command line, or in a plan's file; see docs/training-a-new-robot.md for which to change first.\n"
    })
}
