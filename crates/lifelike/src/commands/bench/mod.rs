//! `lifelike bench`: rates on this machine, disturbances that a policy withstands, and the thesis' tables.

pub mod engine;
pub mod robustness;
pub mod runtime;

// By networks of the training framework.
mod autoencoders;
pub mod critic;
pub mod generation;
pub mod latent;
pub mod learning;
mod seeds;
pub mod tracking;
pub use autoencoders::{control_points, curves, images, reconstruction, strands};

use clap::Subcommand;

use crate::error::CliError;
use crate::output::Output;

/// Measure the engine's speed on this machine and which disturbances a policy withstands, and make the thesis' tables anew.
#[derive(Debug, Subcommand)]
#[allow(missing_docs)] // a comment on a variant would take the place of the command's help text
pub enum Bench {
    ControlPoints(control_points::Args),
    Critic(critic::Args),
    Curves(curves::Args),
    Engine(engine::Args),
    Generation(generation::Args),
    Images(images::Args),
    Latent(latent::Args),
    Learning(learning::Args),
    Reconstruction(reconstruction::Args),
    Robustness(robustness::Args),
    Runtime(runtime::Args),
    Strands(strands::Args),
    Tracking(tracking::Args),
}

impl Bench {
    /// Runs it.
    ///
    /// # Errors
    /// As the command.
    pub fn run(self, output: &Output) -> Result<(), CliError> {
        match self {
            Self::ControlPoints(args) => control_points::run(&args, output),
            Self::Critic(args) => critic::run(&args, output),
            Self::Curves(args) => curves::run(&args, output),
            Self::Engine(args) => engine::run(&args, output),
            Self::Generation(args) => generation::run(&args, output),
            Self::Images(args) => images::run(&args, output),
            Self::Latent(args) => latent::run(&args, output),
            Self::Learning(args) => learning::run(&args, output),
            Self::Reconstruction(args) => reconstruction::run(&args, output),
            Self::Robustness(args) => robustness::run(&args, output),
            Self::Runtime(args) => runtime::run(&args, output),
            Self::Strands(args) => strands::run(&args, output),
            Self::Tracking(args) => tracking::run(&args, output),
        }
    }
}
