//! The commands, one file each.

pub mod bench;
mod clips;
pub mod demo;
pub mod eval;
pub mod inspect;
pub mod motion;
mod physics;
mod prior_file;
mod reconstruction;
pub mod robots;
pub mod train;

use clap::Subcommand;

use crate::error::CliError;
use crate::output::Output;

/// What can be done.
#[derive(Debug, Subcommand)]
pub enum Command {
    Robots(robots::Args),
    Inspect(inspect::Args),
    #[command(subcommand)]
    Motion(motion::Motion),
    #[command(subcommand)]
    Train(train::Train),
    Eval(eval::Args),
    Demo(demo::Args),
    #[command(subcommand)]
    Bench(bench::Bench),
}

impl Command {
    /// Does it.
    pub fn run(self, output: &Output) -> Result<(), CliError> {
        match self {
            Self::Robots(args) => robots::run(&args, output),
            Self::Inspect(args) => inspect::run(&args, output),
            Self::Motion(motion) => motion.run(output),
            Self::Train(train) => train.run(output),
            Self::Eval(args) => eval::run(&args, output),
            Self::Demo(args) => demo::run(&args, output),
            Self::Bench(bench) => bench.run(output),
        }
    }
}
