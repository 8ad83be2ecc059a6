//! `lifelike bench`: how fast things are here, how much a policy bears, and the thesis' tables.

mod autoencoders;
mod engine;
mod latent;
mod learning;
mod machine;
mod robustness;
mod tracking;

use autoencoders::{curves, images, reconstruction, strands};
use clap::Subcommand;

use crate::error::CliError;
use crate::output::Output;

/// Measure the engine's speed on this machine and how much a policy bears, and make the thesis' tables anew.
#[derive(Debug, Subcommand)]
pub enum Bench {
    Curves(curves::Args),
    Engine(engine::Args),
    Images(images::Args),
    Latent(latent::Args),
    Learning(learning::Args),
    Reconstruction(reconstruction::Args),
    Robustness(robustness::Args),
    Strands(strands::Args),
    Tracking(tracking::Args),
}

impl Bench {
    /// Does it.
    pub fn run(self, output: &Output) -> Result<(), CliError> {
        match self {
            Self::Curves(args) => curves::run(&args, output),
            Self::Engine(args) => engine::run(&args, output),
            Self::Images(args) => images::run(&args, output),
            Self::Latent(args) => latent::run(&args, output),
            Self::Learning(args) => learning::run(&args, output),
            Self::Reconstruction(args) => reconstruction::run(&args, output),
            Self::Robustness(args) => robustness::run(&args, output),
            Self::Strands(args) => strands::run(&args, output),
            Self::Tracking(args) => tracking::run(&args, output),
        }
    }
}
