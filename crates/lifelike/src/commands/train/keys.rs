//! `lifelike train tracker --keys`: every key of a plan with its default, unit and meaning.

use lifelike_report::{Cell, Column, Table};
use lifelike_tracking::plan::keys::{PlanKey, keys};
use serde_json::{Value, json};

use crate::error::CliError;
use crate::output::Output;

/// Prints the keys of a tracker's plan.
pub fn tracker(output: &Output) -> Result<(), CliError> {
    let keys = keys().map_err(|e| CliError::Failed(format!("default plan: {e}")))?;
    let value = |k: &PlanKey| json!({ "key": k.key, "default": k.default, "unit": k.unit, "meaning": k.meaning });
    let values: Vec<Value> = keys.iter().map(value).collect();
    output.result(&values, || {
        let mut table = Table::new("Keys", ["key", "default", "unit", "meaning"].map(Column::text).into());
        table.rows = keys.iter().map(|k| [&k.key, &k.default, &k.unit, &k.meaning].map(Cell::text).into()).collect();
        crate::output::fitted(&table)
            + "\nGive them as KEY=VALUE on the command line, or in a plan's file: `lifelike plans track > my.toml` begins one. \
               KEY= takes a value out of a plan.\n"
    })
}
