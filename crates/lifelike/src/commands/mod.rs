//! The commands, one file each: arguments as a type, and a function `run` that takes them.

pub mod bench;
mod bus;
pub mod clips;
pub mod completions;
pub mod config;
pub mod controller_file;
pub mod dataset;
pub mod demo;
pub mod eval;
pub mod export;
mod families;
pub mod fetch;
pub mod import;
pub mod inspect;
pub(crate) mod machine;
pub mod man;
pub mod motion;
pub mod physics;
pub mod plans;
pub mod play;
pub mod render;
pub mod replay;
pub mod robots;
pub mod run;
mod script;
pub mod simulate_robot;
mod stage;
pub mod studio;

pub mod align;
pub mod augment;
pub mod best_of;
pub mod cotrain;
pub mod generate;
mod generated;
mod judge;
pub mod prior_file;
pub mod projection;
pub mod reconstruction;
pub mod rollouts;
pub mod train;

use clap::Subcommand;

use crate::error::CliError;
use crate::output::Output;

/// The command's arguments, by its name. Each is documented where it is defined.
#[derive(Debug, Subcommand)]
#[allow(missing_docs)] // a comment here would take the place of the command's help text
pub enum Command {
    Robots(robots::Args),
    Plans(plans::Args),
    Inspect(inspect::Args),
    #[command(subcommand)]
    Motion(motion::Motion),
    #[command(subcommand)]
    Dataset(dataset::Dataset),
    Train(train::Args),
    Align(align::Args),
    Cotrain(cotrain::Args),
    #[command(subcommand)]
    Augment(augment::Augment),
    Generate(generate::Args),
    Eval(eval::Args),
    Render(render::Args),
    Demo(demo::Args),
    Play(play::Args),
    Studio(studio::Args),
    Export(export::Args),
    Run(run::Args),
    SimulateRobot(simulate_robot::Args),
    Replay(replay::Args),
    Import(import::Args),
    #[command(subcommand)]
    Bench(bench::Bench),
    Fetch(fetch::Args),
    Config(config::Args),
    Completions(completions::Args),
    #[command(hide = true)]
    Man(man::Args),
}

impl Command {
    /// Runs it.
    ///
    /// # Errors
    /// As the command; the error's code is the program's exit code.
    pub fn run(self, output: &Output) -> Result<(), CliError> {
        match self {
            Self::Robots(args) => robots::run(&args, output),
            Self::Plans(args) => plans::run(&args, output),
            Self::Inspect(args) => inspect::run(&args, output),
            Self::Motion(motion) => motion.run(output),
            Self::Dataset(dataset) => dataset.run(output),
            Self::Train(args) => train::run(&args, output),
            Self::Align(args) => align::run(&args, output),
            Self::Cotrain(args) => cotrain::run(&args, output),
            Self::Augment(augment) => augment.run(output),
            Self::Generate(args) => generate::run(&args, output),
            Self::Eval(args) => eval::run(&args, output),
            Self::Render(args) => render::run(&args, output),
            Self::Demo(args) => demo::run(&args, output),
            Self::Play(args) => play::run(&args, output),
            Self::Studio(args) => studio::run(&args, output),
            Self::Export(args) => export::run(&args, output),
            Self::Run(args) => run::run(&args, output),
            Self::SimulateRobot(args) => simulate_robot::run(&args, output),
            Self::Replay(args) => replay::run(&args, output),
            Self::Import(args) => import::run(&args, output),
            Self::Bench(bench) => bench.run(output),
            Self::Fetch(args) => fetch::run(&args, output),
            Self::Config(args) => config::run(&args, output),
            Self::Completions(args) => completions::run(&args),
            Self::Man(args) => man::run(&args),
        }
    }
}
