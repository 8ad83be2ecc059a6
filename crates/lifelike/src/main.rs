//! The program `lifelike`: its whole work is in the library.

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    lifelike::Cli::parse().execute()
}
