//! Logs of real servos.
//!
//! [`bam`] reads those of BAM's test benches, [`table`] tables of a robot's joints with a small map of their columns. Nothing is
//! resampled unless it is asked for ([`BenchLog::at`]), and what is wrong with a log is said with its place.

pub mod bam;
mod clock;
pub mod table;

pub use bam::{BenchLog, BenchRun};
pub use clock::{Clock, delay};
