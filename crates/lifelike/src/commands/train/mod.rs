//! `lifelike train ...`: a motion prior, then a policy; a motion spline for editing; an evaluator of text to motion.

pub mod driver;
pub mod evaluator;
pub mod hardware;
mod keys;
pub mod prior;
pub mod processes;
mod source;
pub mod spline;
pub mod tracker;

use clap::Subcommand;

use crate::error::CliError;
use crate::output::Output;

/// Train a motion prior, a tracking policy, a motion spline, or an evaluator of text to motion.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The kind of training.
    #[command(subcommand)]
    pub train: Train,
}

/// The kinds of training.
#[derive(Debug, Subcommand)]
#[allow(missing_docs)] // a comment on a variant would take the place of the command's help text
pub enum Train {
    Prior(prior::Args),
    Tracker(tracker::Args),
    Spline(spline::Args),
    Evaluator(evaluator::Args),
}

/// Runs the command.
///
/// # Errors
/// As the kind of training.
pub fn run(args: &Args, output: &Output) -> Result<(), CliError> {
    match &args.train {
        Train::Prior(args) => prior::run(args, output),
        Train::Tracker(args) => tracker::run(args, output),
        Train::Spline(args) => spline::run(args, output),
        Train::Evaluator(args) => evaluator::run(args, output),
    }
}
