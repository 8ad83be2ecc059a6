//! The program `lifelike-thesis`: its whole work is in the library.

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    lifelike_thesis::Cli::parse().execute()
}
