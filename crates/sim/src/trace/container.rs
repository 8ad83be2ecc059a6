//! Traces as files: `NAME.trace.safetensors`.
//!
//! A [safetensors](https://github.com/huggingface/safetensors) file. For block number B it has the arrays
//! `B.simulated`, `B.force`, `B.reference`, `B.measured` and, of bodies, `B.frame`, f32 `[rows, columns]`, SI units.
//! The metadata's entry `trace` is a JSON header with names, classes, rate and the selections S.

use std::path::Path;

use lifelike_checkpoint::{Checkpoint, CheckpointError};

use super::{BlockTrace, Columns, Selected, Trace};
use crate::error::SimError;

/// Ending of the files' names.
pub const EXTENSION: &str = ".trace.safetensors";
const KEY: &str = "trace";
const FORMAT: &str = "lifelike-trace 1";

#[derive(serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    format: String,
    name: String,
    source: String,
    rate: f64,
    rows: usize,
    blocks: Vec<BlockHeader>,
}

#[derive(serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct BlockHeader {
    name: String,
    class: String,
    simulated: Vec<String>,
    force: Vec<String>,
    reference: Vec<String>,
    measured: Vec<String>,
    selection: Vec<Selected>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    frame: Vec<String>,
}

/// Saves a trace.
///
/// # Errors
/// [`SimError::State`] for a trace that [`Trace::check`] refuses, [`SimError::Checkpoint`] where it cannot be written.
pub fn save(trace: &Trace, path: &Path) -> Result<(), SimError> {
    trace.check()?;
    let rows = trace.len();
    let mut file = Checkpoint::new();
    let mut blocks = Vec::with_capacity(trace.blocks.len());
    for (i, block) in trace.blocks.iter().enumerate() {
        for (part, columns) in parts(block).into_iter().filter(|(part, own)| *part != "frame" || !own.names.is_empty())
        {
            file.put_f32(&format!("{i}.{part}"), &[rows, columns.names.len()], columns.values.clone())?;
        }
        blocks.push(BlockHeader {
            name: block.name.clone(),
            class: block.class.clone(),
            simulated: block.simulated.names.clone(),
            force: block.force.names.clone(),
            reference: block.reference.names.clone(),
            measured: block.measured.names.clone(),
            selection: block.selection.clone(),
            frame: block.frame.names.clone(),
        });
    }
    let Trace { name, source, rate, .. } = trace.clone();
    file.set_meta(KEY, &Header { format: FORMAT.into(), name, source, rate, rows, blocks })?;
    Ok(file.save(path)?)
}

/// Loads a trace.
///
/// # Errors
/// [`SimError::Checkpoint`] for a file that is none or damaged, [`SimError::State`] for one that [`Trace::check`] refuses.
pub fn load(path: &Path) -> Result<Trace, SimError> {
    let file = Checkpoint::load(path)?;
    let header: Header = file.meta(KEY)?;
    if header.format != FORMAT {
        let expected = format!("{}: a trace of format '{FORMAT}'", path.display());
        return Err(SimError::State { expected, got: format!("'{}'", header.format) });
    }
    let columns = |i: usize, part: &str, names: Vec<String>| -> Result<Columns, CheckpointError> {
        let values = file.f32s(&format!("{i}.{part}"), &[header.rows, names.len()])?;
        Ok(Columns { names, values })
    };
    let mut blocks = Vec::with_capacity(header.blocks.len());
    for (i, block) in header.blocks.into_iter().enumerate() {
        blocks.push(BlockTrace {
            name: block.name,
            class: block.class,
            simulated: columns(i, "simulated", block.simulated)?,
            force: columns(i, "force", block.force)?,
            reference: columns(i, "reference", block.reference)?,
            measured: columns(i, "measured", block.measured)?,
            selection: block.selection,
            frame: match block.frame.is_empty() {
                true => Columns::default(),
                false => columns(i, "frame", block.frame)?,
            },
        });
    }
    let trace = Trace { name: header.name, source: header.source, rate: header.rate, blocks };
    trace.check()?;
    Ok(trace)
}

fn parts(block: &BlockTrace) -> [(&'static str, &Columns); 5] {
    [
        ("simulated", &block.simulated),
        ("force", &block.force),
        ("reference", &block.reference),
        ("measured", &block.measured),
        ("frame", &block.frame),
    ]
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn trace() -> Trace {
        let mut block = BlockTrace {
            name: "knee".into(),
            class: "servo".into(),
            simulated: Columns::new(&[("position", &[0.0, 0.5]), ("velocity", &[1.0, 2.0])]),
            force: Columns::new(&[("load", &[0.1, 0.2])]),
            reference: Columns::new(&[("position", &[0.3, 0.4])]),
            measured: Columns::new(&[("position", &[0.25, 0.5])]),
            selection: Vec::new(),
            frame: Columns::new(&[("position_x", &[0.5, 1.0])]),
        };
        block.selection = block.by_name();
        Trace { name: "run".into(), source: "test".into(), rate: 50.0, blocks: vec![block] }
    }

    #[test]
    fn what_is_saved_is_loaded() {
        let folder = std::env::temp_dir().join(format!("lifelike-trace-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join(format!("run{EXTENSION}"));
        save(&trace(), &file).unwrap();
        let loaded = load(&file).unwrap();
        assert_eq!(loaded, trace());
        assert_eq!(loaded.blocks[0].error(), [0.25, 0.0]);
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn traces_that_do_not_fit_themselves_are_refused_with_their_place() {
        let refused = |change: fn(&mut Trace)| {
            let mut trace = trace();
            change(&mut trace);
            trace.check().unwrap_err().to_string()
        };
        let text = refused(|trace| trace.blocks[0].simulated.values[3] = f32::NAN);
        assert!(text.contains("block 'knee', simulated: a finite 'velocity' in row 1"), "{text}");
        let text = refused(|trace| trace.blocks[0].force.values.truncate(1));
        assert!(text.contains("force: 2 rows of 1 numbers, got 1 numbers"), "{text}");
        let text = refused(|trace| trace.blocks[0].selection[0].state[0].0 = "angle".into());
        assert!(text.contains("got 'angle'"), "{text}");
        assert!(refused(|trace| trace.rate = 0.0).contains("a rate above 0 Hz"));
    }
}
