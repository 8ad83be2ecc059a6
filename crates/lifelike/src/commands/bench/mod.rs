//! `lifelike bench`: how fast things are here, and what a space of latent codes is worth.

mod engine;
mod latent;
mod machine;

use clap::Subcommand;

use crate::error::CliError;
use crate::output::Output;

/// Measure the engine's speed on this machine, and the quality of latent codes.
#[derive(Debug, Subcommand)]
pub enum Bench {
    Engine(engine::Args),
    Latent(latent::Args),
}

impl Bench {
    /// Does it.
    pub fn run(self, output: &Output) -> Result<(), CliError> {
        match self {
            Self::Engine(args) => engine::run(&args, output),
            Self::Latent(args) => latent::run(&args, output),
        }
    }
}
