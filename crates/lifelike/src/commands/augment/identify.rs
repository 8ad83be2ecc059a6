//! `lifelike augment identify`: the parameters of a servo by least squares on its logs.

use std::path::PathBuf;

use lifelike_augmentation::identification::{FrictionModel, fit};
use lifelike_augmentation::logs::{BenchLog, BenchRun};
use lifelike_report::{Cell, Column, Table};
use serde_json::json;

use super::sources;
use crate::error::CliError;
use crate::output::Output;

/// Fit the parameters of a servo's model to logs of its test bench: motor, armature, delay, friction.
///
/// Least squares (Levenberg-Marquardt) over whole simulated runs, from several starts. Friction models are those of Duclusaud et
/// al. 2024: m1 Coulomb and viscous, m2 with Stribeck's, m3 to m6 with load. A Dynamixel's gain is known; a Feetech's, and the limit of
/// its reference's speed, are fitted with the rest.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  lifelike augment identify logs/ --friction m6 -o xl330.toml
  lifelike augment identify logs/ --test held_out/ --friction m1 -o plain.toml")]
pub struct Args {
    /// Logs to fit to: files, or folders of *.json.
    #[arg(required = true)]
    pub logs: Vec<PathBuf>,
    /// Logs that are only measured on.
    #[arg(long, num_args = 1..)]
    pub test: Vec<PathBuf>,
    /// Friction: m1, m2, m3, m4, m5 or m6.
    #[arg(long, default_value = "m6")]
    pub friction: String,
    /// The servo that is searched around: a data sheet's (xl330, sts3250) or a file of this command; as the logs say if not given.
    #[arg(long)]
    pub servo: Option<String>,
    /// Rows per second of the simulation (Hz).
    #[arg(long, default_value_t = 200.0, allow_negative_numbers = true)]
    pub rate: f64,
    /// Starts of the search.
    #[arg(long, default_value_t = 6, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub starts: u64,
    /// Key of the starts.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// The file to write (TOML).
    #[arg(short, long, value_parser = crate::destination::toml)]
    pub output: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    crate::bounds::row_rate("--rate", args.rate)?;
    let model = FrictionModel::ALL.into_iter().find(|model| model.name() == args.friction).ok_or_else(|| {
        let known = FrictionModel::ALL.map(FrictionModel::name).join(", ");
        CliError::Usage(format!("--friction: expected {known}, got '{}'", args.friction))
    })?;
    let read = |paths: &[PathBuf]| -> Result<Vec<(BenchLog, BenchRun)>, CliError> {
        let logs = sources::bench_logs(paths)?;
        Ok(logs.into_iter().map(|log| (log.clone(), log.at(args.rate))).collect())
    };
    let (learn, test) = (read(&args.logs)?, read(&args.test)?);
    let runs: Vec<(&BenchLog, &BenchRun)> = learn.iter().map(|(log, run)| (log, run)).collect();
    let logs: Vec<BenchLog> = learn.iter().map(|(log, _)| log.clone()).collect();
    let around = sources::servo(args.servo.as_deref(), &logs)?;
    let servo = fit(model, &around, &runs, args.starts, args.seed);
    let text = toml::to_string(&servo).map_err(|error| CliError::Failed(error.to_string()))?;
    let names: Vec<&str> = learn.iter().map(|(log, _)| log.name.as_str()).collect();
    let text = format!("# Fitted ({}) to {}.\n{text}", model.name(), names.join(", "));
    crate::output::write(&args.output, text)?;
    let mut table = Table::new(
        "Mean absolute error of the position",
        vec![Column::text("log"), Column::text("used to"), Column::number("error", "deg")],
    );
    let mut errors = Vec::new();
    for (use_, logs) in [("fit", &learn), ("test", &test)] {
        for (log, run) in logs {
            let error = servo.error(&[(log, run)]).to_degrees();
            errors.push(json!({ "log": log.name, "use": use_, "mae_deg": error }));
            table.rows.push(vec![Cell::text(log.name.clone()), Cell::text(use_), Cell::number(error, 2)]);
        }
    }
    let value = json!({ "servo": servo, "file": args.output, "errors": errors });
    output.result(&value, || format!("{}\nservo: {}\n", crate::output::fitted(&table), args.output.display()))
}
