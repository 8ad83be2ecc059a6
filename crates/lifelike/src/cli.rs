//! The command line as one value: parsed arguments, logs, exit code.

use std::io::IsTerminal;
use std::process::ExitCode;

use clap::{ArgAction, Parser};
use tracing_subscriber::filter::LevelFilter;

use crate::commands::Command;
use crate::error::CliError;
use crate::output::Output;

/// Lifelike motion for robots and physics-based characters.
///
/// Retarget human motion to any robot, learn a motion prior and a policy that follows it in physics, and look at it.
#[derive(Debug, Parser)]
#[command(name = "lifelike", version, propagate_version = true, max_term_width = 100, after_help = AFTER)]
pub struct Cli {
    /// Print JSON for scripts instead of text.
    #[arg(long, global = true)]
    pub json: bool,
    /// Say more on standard error; twice for even more.
    #[arg(short, long, global = true, action = ArgAction::Count)]
    pub verbose: u8,
    /// Say nothing but errors on standard error.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

const AFTER: &str = "\
A first policy in minutes, on our own keyframed clips, without any download:
  lifelike train tracker --plan track -o runs/first budget.minutes=5
  lifelike eval --policy runs/first/tracker.policy.safetensors --motions builtin -o runs/first/evaluation

From captured motion to a robot that follows it:
  lifelike motion retarget walk.bvh --robot lima -o data/lima
  lifelike train tracker --plan track 'clips=[\"data/lima\"]' -o runs/mine
  lifelike eval --policy runs/mine/tracker.policy.safetensors --motions data/lima -o report

`lifelike plans` lists the training plans that come with the program.

Vector instructions are the best of this machine; LIFELIKE_SIMD=avx2 (or another that `lifelike inspect --machine` lists)
forces others.

Exit codes: 0 done, 1 failed, 2 wrong usage, 3 bad input, 4 this build cannot do it, 130 interrupted (and saved).";

impl Cli {
    /// Runs the command, prints its result or its error, and returns the exit code.
    pub fn execute(self) -> ExitCode {
        #[cfg(feature = "learning")]
        lifelike_nn::memory::tune_allocator();
        self.start_logs();
        let output = Output { json: self.json, quiet: self.quiet, silent: false };
        match self.command.run(&output) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                output.error(&error);
                ExitCode::from(error.code())
            }
        }
    }

    fn start_logs(&self) {
        let level = match (self.quiet, self.verbose) {
            (true, _) => LevelFilter::ERROR,
            (false, 0) => LevelFilter::INFO,
            (false, 1) => LevelFilter::DEBUG,
            (false, _) => LevelFilter::TRACE,
        };
        let log = tracing_subscriber::fmt().with_max_level(level).with_writer(std::io::stderr).with_target(false);
        log.without_time().with_ansi(std::io::stderr().is_terminal()).init();
    }
}

/// Runs one command line, without the program's name, in the calling process.
///
/// # Errors
/// [`CliError::Usage`] for arguments that are none, else as the command.
pub fn run(arguments: &[&str]) -> Result<(), CliError> {
    let cli = Cli::try_parse_from(std::iter::once(&"lifelike").chain(arguments))
        .map_err(|e| CliError::Usage(e.to_string()))?;
    cli.command.run(&Output { json: cli.json, quiet: cli.quiet, silent: false })
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_arguments_are_consistent() {
        super::Cli::command().debug_assert();
    }
}
