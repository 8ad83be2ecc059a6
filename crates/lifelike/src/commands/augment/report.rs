//! `lifelike augment report`: how far a simulation is from what was measured, and where.

use std::path::PathBuf;

use lifelike_augmentation::{Augmentation, gap};
use serde_json::json;

use super::{FeedbackName, page, sources};
use crate::error::CliError;
use crate::output::Output;

/// Show how far a simulation is from what was measured: how much, where, how fast, how late; also after a correction.
///
/// Each joint gets its mean absolute and largest error, concordance correlation (CCC, 1 is agreement) and delay. The
/// error is also split by frequency, and by condition: at rest, under load, at changes of direction. Of a record, the
/// simulation starts from what was measured every 0.1 s.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike augment report traces/nominal -o report
  lifelike augment report walk.mcap -o report          # a record of `lifelike run`
  lifelike augment report traces/test --augmentation xl330.augmentation.safetensors -o report
  lifelike --json augment report traces/nominal | jq '.gaps[] | {run, column, mae}'")]
pub struct Args {
    /// Traces with measurements: files, folders of them, or records (*.mcap).
    #[arg(required = true)]
    pub traces: Vec<PathBuf>,
    /// A correction to be shown beside the plain simulation: what `lifelike train augmentation` leaves.
    #[arg(long)]
    pub augmentation: Option<PathBuf>,
    /// Earlier errors that the correction reads.
    #[arg(long, value_enum, default_value = "none", requires = "augmentation")]
    pub feedback: FeedbackName,
    /// Folder for gap.json and report.html.
    #[arg(short, long, value_parser = crate::destination::folder)]
    pub output: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    let traces = sources::traces(&args.traces)?;
    let mut shown = vec![("simulation", traces)];
    if let Some(file) = &args.augmentation {
        let augmentation = Augmentation::load(file)?;
        let corrected = shown[0].1.iter().map(|trace| augmentation.corrected(trace, args.feedback.into()));
        let corrected = corrected.collect::<Result<Vec<_>, _>>()?;
        shown.push(("corrected", corrected));
    }
    let measured: Vec<(&str, Vec<gap::Gap>)> =
        shown.iter().map(|(name, traces)| (*name, traces.iter().flat_map(gap::gaps).collect())).collect();
    if measured[0].1.is_empty() {
        return Err(CliError::Input("expected traces with measured columns, got none".into()));
    }
    let summaries: Vec<_> = measured.iter().map(|(name, gaps)| (*name, gap::summary(gaps))).collect();
    let value = json!({
        "summary": summaries.iter().map(|(name, summary)| json!({ "of": name, "columns": summary })).collect::<Vec<_>>(),
        "gaps": measured.iter().flat_map(|(name, gaps)| gaps.iter().map(move |gap| json!({ "of": name, "gap": gap }))).collect::<Vec<_>>(),
    });
    if let Some(folder) = &args.output {
        page::save(folder, &value, &shown, &measured)?;
    }
    output.result(&value, || {
        let tables = summaries
            .iter()
            .map(|(name, summary)| format!("{name}:\n{}\n", crate::output::fitted(&page::summary(summary))));
        let page = args.output.as_ref().map_or(String::new(), |folder| {
            format!("open this in a browser: {}\n", folder.join("report.html").display())
        });
        let worst = measured.iter().map(|(name, gaps)| crate::output::fitted(&page::worst(name, gaps)));
        format!("{}{}{page}", tables.collect::<String>(), worst.collect::<String>())
    })
}
