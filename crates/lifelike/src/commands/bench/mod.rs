//! `lifelike bench`: rates on this machine, and disturbances that a policy withstands.

pub mod engine;
pub mod get_up;
pub mod learning;
pub mod robustness;
pub mod runtime;

use clap::Subcommand;

use crate::error::CliError;
use crate::output::Output;

/// Measure speeds on this machine and which disturbances a policy withstands.
#[derive(Debug, Subcommand)]
#[allow(missing_docs)] // a comment on a variant would take the place of the command's help text
pub enum Bench {
    Engine(engine::Args),
    GetUp(get_up::Args),
    Learning(learning::Args),
    Robustness(robustness::Args),
    Runtime(runtime::Args),
}

impl Bench {
    /// Runs it.
    ///
    /// # Errors
    /// As the command.
    pub fn run(self, output: &Output) -> Result<(), CliError> {
        match self {
            Self::Engine(args) => engine::run(&args, output),
            Self::GetUp(args) => get_up::run(&args, output),
            Self::Learning(args) => learning::run(&args, output),
            Self::Robustness(args) => robustness::run(&args, output),
            Self::Runtime(args) => runtime::run(&args, output),
        }
    }
}
