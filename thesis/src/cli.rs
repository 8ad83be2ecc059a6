//! The command line of `lifelike-thesis`.

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use lifelike::{CliError, GlobalOptions, Output};

use crate::autoencoders::{control_points, curves, images, reconstruction, strands};
use crate::{critic, generation, latent, tracking};

/// Make the tables of the thesis Lifelike Motions for Robotic Characters anew, beside the published numbers.
#[derive(Debug, Parser)]
#[command(
    name = "lifelike-thesis",
    version,
    max_term_width = 100,
    after_help = "\
Examples:
  lifelike-thesis curves --budget smoke -o runs/smoke   # Table 3.1 in a minute: does it work at all?
  lifelike-thesis latent --prior lima --motions data/lima
  lifelike-thesis tracking --study thesis/experiments/study-thesis.toml -o runs/thesis"
)]
pub struct Cli {
    #[command(flatten)]
    options: GlobalOptions,
    #[command(subcommand)]
    table: Table,
}

#[derive(Debug, Subcommand)]
enum Table {
    ControlPoints(control_points::Args),
    Critic(critic::Args),
    Curves(curves::Args),
    Generation(generation::Args),
    Images(images::Args),
    Latent(latent::Args),
    Reconstruction(reconstruction::Args),
    Strands(strands::Args),
    Tracking(tracking::Args),
}

impl Cli {
    /// Runs the command, prints its result or its error, and returns the exit code.
    pub fn execute(self) -> ExitCode {
        ExitCode::from(self.options.execute(|output| self.table.run(output)))
    }
}

impl Table {
    fn run(&self, output: &Output) -> Result<(), CliError> {
        match self {
            Self::ControlPoints(args) => control_points::run(args, output),
            Self::Critic(args) => critic::run(args, output),
            Self::Curves(args) => curves::run(args, output),
            Self::Generation(args) => generation::run(args, output),
            Self::Images(args) => images::run(args, output),
            Self::Latent(args) => latent::run(args, output),
            Self::Reconstruction(args) => reconstruction::run(args, output),
            Self::Strands(args) => strands::run(args, output),
            Self::Tracking(args) => tracking::run(args, output),
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_arguments_are_consistent_and_teach_by_example() {
        let command = super::Cli::command();
        command.clone().debug_assert();
        for table in command.get_subcommands() {
            let examples = table.get_after_help().map(ToString::to_string).unwrap_or_default();
            assert!(examples.contains("lifelike-thesis"), "{}: {examples}", table.get_name());
        }
    }
}
