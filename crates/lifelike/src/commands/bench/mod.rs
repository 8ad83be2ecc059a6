//! `lifelike bench`: how fast things are here, and how much a policy bears.

mod engine;
mod machine;
mod robustness;

use clap::Subcommand;

use crate::error::CliError;
use crate::output::Output;

/// Measure speed on this machine, and how much a policy bears.
#[derive(Debug, Subcommand)]
pub enum Bench {
    Engine(engine::Args),
    Robustness(robustness::Args),
}

impl Bench {
    /// Does it.
    pub fn run(self, output: &Output) -> Result<(), CliError> {
        match self {
            Self::Engine(args) => engine::run(&args, output),
            Self::Robustness(args) => robustness::run(&args, output),
        }
    }
}
