//! `lifelike augment simulate`: logs and what a simulation makes of their commands, side by side.

use std::path::PathBuf;

use lifelike_augmentation::gap;
use lifelike_sim::trace::{Trace, container};
use serde_json::json;

use super::{page, sources};
use crate::error::CliError;
use crate::next::NextCommand;
use crate::output::Output;

/// Simulate the commands of logs, and write traces that have simulated and measured states side by side.
///
/// Logs are those of BAM's test benches (a servo that turns a weight on an arm, JSON). They are taken to equal time steps of --rate;
/// the simulation begins where the log does and runs freely.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike augment simulate logs/ --servo xl330 -o traces/nominal
  lifelike augment identify logs/ --friction m6 -o xl330.toml
  lifelike augment simulate logs/ --servo xl330.toml -o traces/fitted")]
pub struct Args {
    /// Logs: files, or folders of *.json.
    #[arg(required = true)]
    pub logs: Vec<PathBuf>,
    /// The servo's model: a file of `lifelike augment identify`, or xl330 (its data sheet).
    #[arg(long, default_value = "xl330")]
    pub servo: String,
    /// Rows per second (Hz).
    #[arg(long, default_value_t = 200.0)]
    pub rate: f64,
    /// Folder of the traces.
    #[arg(short, long)]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    if !(1.0..=10_000.0).contains(&args.rate) {
        return Err(CliError::Usage(format!("--rate: expected 1 to 10000 Hz, got {}", args.rate)));
    }
    let (logs, servo) = (sources::bench_logs(&args.logs)?, sources::servo(&args.servo)?);
    std::fs::create_dir_all(&args.output).map_err(CliError::write(&args.output))?;
    let traces: Vec<Trace> = logs.iter().map(|log| log.at(args.rate).simulated(log, &servo.bench(log))).collect();
    let mut files = Vec::with_capacity(traces.len());
    for trace in &traces {
        let file = args.output.join(format!("{}{}", trace.name, container::EXTENSION));
        container::save(trace, &file)?;
        files.push(file);
    }
    let summary = gap::summary(&traces.iter().flat_map(gap::gaps).collect::<Vec<_>>());
    let value = json!({ "files": files, "servo": servo, "gap": summary });
    output.result(&value, || {
        let next = NextCommand::new("augment report").word(args.output.display()).word("-o").word("report");
        format!(
            "{}\n{} traces in {}\nnext: {next}\n",
            page::summary(&summary).to_text(),
            files.len(),
            args.output.display()
        )
    })
}
