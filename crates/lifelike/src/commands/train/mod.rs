//! `lifelike train ...`: a motion prior, then a policy, then its critic; a motion spline for editing; a generator of
//! motion from text, and its evaluator. It also trains an augmentation of simulated states, and
//! searches a script that gets up.

pub mod augmentation;
pub mod critic;
pub mod driver;
pub mod evaluator;
pub mod generator;
pub mod get_up;
pub mod keys;
pub mod language;
#[cfg(feature = "mpi")]
mod mpi;
pub mod prior;
pub mod processes;
pub mod rehearsal;
pub mod source;
pub mod spline;
mod stall;
pub mod tracker;
pub mod watch;

use clap::Subcommand;

use crate::error::CliError;
use crate::output::Output;

/// Train a motion prior, a tracking policy, its critic, a motion spline, a generator, its evaluator, an augmentation, or a get-up
/// script.
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
    Critic(critic::Args),
    Generator(generator::Args),
    Evaluator(evaluator::Args),
    Language(language::Args),
    Augmentation(augmentation::Args),
    GetUp(get_up::Args),
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
        Train::Critic(args) => critic::run(args, output),
        Train::Generator(args) => generator::run(args, output),
        Train::Evaluator(args) => evaluator::run(args, output),
        Train::Language(args) => language::run(args, output),
        Train::Augmentation(args) => augmentation::run(args, output),
        Train::GetUp(args) => get_up::run(args, output),
    }
}
