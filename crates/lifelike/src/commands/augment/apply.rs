//! `lifelike augment apply`: traces with corrected states.

use std::path::PathBuf;

use lifelike_augmentation::Augmentation;
use lifelike_sim::trace::container;
use serde_json::json;

use super::{FeedbackName, sources};
use crate::error::CliError;
use crate::output::Output;

/// Correct the simulated states of traces: s(t) + Δs(t) in place of s(t).
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Example:
  lifelike augment apply traces/nominal --augmentation xl330.augmentation.safetensors \\
      -o traces/corrected")]
pub struct Args {
    /// Traces: files, or folders of them.
    #[arg(required = true)]
    pub traces: Vec<PathBuf>,
    /// The correction: what `lifelike train augmentation` leaves.
    #[arg(long)]
    pub augmentation: PathBuf,
    /// Earlier errors that the correction reads.
    #[arg(long, value_enum, default_value = "none")]
    pub feedback: FeedbackName,
    /// Folder of the corrected traces.
    #[arg(short, long, value_parser = crate::destination::folder)]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let (traces, augmentation) = (sources::traces(&args.traces)?, Augmentation::load(&args.augmentation)?);
    std::fs::create_dir_all(&args.output).map_err(CliError::write(&args.output))?;
    let mut files = Vec::with_capacity(traces.len());
    for trace in &traces {
        let file = crate::destination::named(&args.output, &trace.name, container::EXTENSION)?;
        container::save(&augmentation.corrected(trace, args.feedback.into())?, &file)?;
        files.push(file);
    }
    output.result(&json!({ "files": files }), || format!("{} traces in {}\n", files.len(), args.output.display()))
}
