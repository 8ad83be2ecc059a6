//! Networks: those that say what they are, and any other checkpoint.

use std::path::Path;

use lifelike_checkpoint::Checkpoint;
use serde_json::{Value, json};

use crate::error::CliError;
use crate::output::{Output, table};

/// Prints what a checkpoint holds.
pub fn inspect(path: &Path, output: &Output) -> Result<(), CliError> {
    let checkpoint = Checkpoint::load(path)?;
    let numbers: usize = checkpoint.entries().values().map(|e| e.count()).sum();
    if let Some(done) = super::controller::inspect(path, &checkpoint, numbers, output) {
        return done;
    }
    if let Some(done) = super::networks::inspect(path, &checkpoint, numbers, output) {
        return done;
    }
    let arrays: Vec<Value> = checkpoint
        .entries()
        .iter()
        .map(|(name, e)| json!({ "name": name, "shape": e.shape(), "type": format!("{:?}", e.kind()) }))
        .collect();
    let value =
        json!({ "kind": "checkpoint", "numbers": numbers, "metadata": checkpoint.metadata(), "arrays": arrays });
    output.result(&value, || {
        let mut text = format!("{}: a checkpoint of {numbers} numbers in {} arrays\n\n", path.display(), arrays.len());
        for (key, value) in checkpoint.metadata() {
            text += &format!("{key} = {value}\n");
        }
        let rows: Vec<Vec<String>> = checkpoint
            .entries()
            .iter()
            .map(|(name, e)| vec![name.clone(), format!("{:?}", e.shape()), format!("{:?}", e.kind())])
            .collect();
        text + "\n" + &table(&["array", "shape", "type"], &rows)
    })
}
