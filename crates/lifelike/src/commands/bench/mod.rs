//! `lifelike bench`: how fast things are here.

mod engine;
mod machine;

use clap::Subcommand;

use crate::error::CliError;
use crate::output::Output;

/// Measure speed on this machine.
#[derive(Debug, Subcommand)]
pub enum Bench {
    Engine(engine::Args),
}

impl Bench {
    /// Does it.
    pub fn run(self, output: &Output) -> Result<(), CliError> {
        match self {
            Self::Engine(args) => engine::run(&args, output),
        }
    }
}
