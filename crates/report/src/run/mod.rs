//! A run is a folder. Whoever holds the folder holds everything: what was asked for, what happened, what was learned.
//!
//! | file | what |
//! | --- | --- |
//! | `plan.toml` | the resolved plan: every default and override spelled out |
//! | `metrics.jsonl` | one JSON object per logged iteration, deterministic: equal runs give equal bytes |
//! | `snapshots.jsonl` | values of many items (clips) at a few iterations, deterministic too |
//! | `timing.jsonl` | what the clock says; differs from run to run, hence apart |
//! | `machine.jsonl` | processor, cores and vector instructions of each sitting |
//! | `events.out.tfevents.*` | the same numbers for TensorBoard |
//! | `checkpoints/` | the last few and the best |
//! | `report.html` | everything above in one page that a browser opens |
//!
//! The main path: [`RunFolder::create`] → [`RunFolder::start_metrics`] → [`MetricsWriter::log`] each iteration →
//! [`MetricsWriter::sync`] and [`Checkpoints::save`] now and then. After a kill: [`Checkpoints::latest`] →
//! [`RunFolder::resume_metrics`] at the byte that the checkpoint remembers, and the file continues as if nothing had
//! happened.

mod checkpoints;
mod events;
mod folder;
mod metrics;
mod snapshots;

pub use checkpoints::{CheckpointInfo, Checkpoints};
pub use events::EventWriter;
pub use folder::RunFolder;
pub use metrics::{MetricsRow, MetricsWriter, read_metrics};
pub use snapshots::{Snapshot, SnapshotWriter};
