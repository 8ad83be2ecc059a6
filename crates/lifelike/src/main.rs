//! Floor 5: the command line. Arguments → plan → run → table, plot, file.
//!
//! One file per command under [`commands`]; the libraries below do the work. What a person reads goes to standard
//! output, what a script reads too with `--json`; progress and logs go to standard error.

mod commands;
mod error;
mod interrupt;
mod output;
mod overrides;
mod progress;

use std::io::IsTerminal;
use std::process::ExitCode;

use clap::{ArgAction, Parser};
use tracing_subscriber::filter::LevelFilter;

use crate::commands::Command;
use crate::output::Output;

/// Lifelike motion for robots and physics-based characters.
///
/// Retarget human motion to any robot, learn a motion prior and a policy that follows it in physics, and look at it.
#[derive(Debug, Parser)]
#[command(name = "lifelike", version, propagate_version = true, max_term_width = 100, after_help = AFTER)]
struct Cli {
    /// Print JSON for scripts instead of text.
    #[arg(long, global = true)]
    json: bool,
    /// Say more on standard error; twice for even more.
    #[arg(short, long, global = true, action = ArgAction::Count)]
    verbose: u8,
    /// Say nothing but errors on standard error.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    #[command(subcommand)]
    command: Command,
}

const AFTER: &str = "\
The way from mocap to a robot that follows it:
  lifelike motion retarget walk.bvh --robot lima -o data/lima
  lifelike train prior   --plan experiments/prior.toml
  lifelike train tracker --plan experiments/track.toml
  lifelike eval --policy runs/track/tracker.policy.safetensors --motions data/lima -o report

Exit codes: 0 done, 1 failed, 2 wrong usage, 3 bad input, 4 this build cannot do it, 130 interrupted (and saved).";

fn main() -> ExitCode {
    lifelike_nn::memory::tune_allocator();
    let cli = Cli::parse();
    let level = match (cli.quiet, cli.verbose) {
        (true, _) => LevelFilter::ERROR,
        (false, 0) => LevelFilter::INFO,
        (false, 1) => LevelFilter::DEBUG,
        (false, _) => LevelFilter::TRACE,
    };
    let log = tracing_subscriber::fmt().with_max_level(level).with_writer(std::io::stderr).with_target(false);
    log.without_time().with_ansi(std::io::stderr().is_terminal()).init();
    let output = Output { json: cli.json, quiet: cli.quiet };
    match cli.command.run(&output) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            output.error(&error);
            ExitCode::from(error.code())
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_arguments_are_consistent() {
        super::Cli::command().debug_assert();
    }
}
