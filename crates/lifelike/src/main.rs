//! The program `lifelike`: its whole work is in the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    lifelike::Cli::of_arguments().execute()
}
