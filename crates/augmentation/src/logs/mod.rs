//! Logs of real servos.
//!
//! [`bam`] reads those of test benches (BAM's, and tables by [`bench_table`]). [`table`] reads tables of a robot's joints (CSV, or bags
//! of ROS 2) with a small map of their columns. Nothing is
//! resampled unless it is asked for ([`BenchLog::at`]), and what is wrong with a log is said with its place.

mod bag;
pub mod bam;
mod bench_checks;
pub mod bench_table;
mod clock;
mod load;
pub mod table;
mod table_checks;

pub use bam::{BenchLog, BenchRun};
pub use clock::{Clock, delay};
pub use table_checks::small_angles;
