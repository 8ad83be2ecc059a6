//! `lifelike man`: manual pages, for packages.

use std::path::PathBuf;

use clap::CommandFactory;

use crate::cli::Cli;
use crate::error::CliError;

/// Write a manual page for every command.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of the pages.
    #[arg(short, long, value_parser = crate::destination::folder)]
    pub output: PathBuf,
}

/// Runs the command.
///
/// # Errors
/// A file cannot be written.
pub fn run(args: &Args) -> Result<(), CliError> {
    std::fs::create_dir_all(&args.output).map_err(CliError::write(&args.output))?;
    clap_mangen::generate_to(Cli::command(), &args.output).map_err(CliError::write(&args.output))
}
